"""From listed patches to their features, whatever the files hold."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from grounding.errors import InputError
from grounding.features.background import NoObject
from grounding.features.embedding import Embedding
from grounding.features.image import read_patch
from grounding.features.registry import PatchFeatures, extract_features
from grounding.symbols.listing import ListedPatch
from grounding.symbols.records import LabelledPatch


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeasuredPatch:
    """A listed patch with what was measured.

    Attributes:
        listed: the row.
        features: None where the image could not be read.
        note: one line on what was wrong or unusual; empty for nothing.
    """

    listed: ListedPatch
    features: PatchFeatures | NoObject | None
    note: str = ""


def measure(
    listed: Iterable[ListedPatch], *, embedding: Embedding | None = None
) -> Iterator[MeasuredPatch]:
    """Yield each patch with its features; an image that cannot be read stops nothing."""
    for each in listed:
        try:
            image = read_patch(each.path)
        except InputError as error:
            yield MeasuredPatch(listed=each, features=None, note=str(error))
            continue
        features = extract_features(
            image.bgr, mask=image.mask, mm_per_px=each.mm_per_px, embedding=embedding
        )
        note = f"no object: {features.reason}" if isinstance(features, NoObject) else image.note
        yield MeasuredPatch(
            listed=each, features=features, note=f"{each.path}: {note}" if note else ""
        )


def labelled(patches: Iterable[MeasuredPatch]) -> list[LabelledPatch]:
    """Return the patches that could be read, with their labels."""
    return [
        LabelledPatch(
            features=patch.features,
            symbols=patch.listed.symbols,
            segment=patch.listed.segment,
            weight=patch.listed.weight,
            name=patch.listed.name,
        )
        for patch in patches
        if patch.features is not None and patch.listed.symbols
    ]
