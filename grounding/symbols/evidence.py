"""Labelled patches as arrays: which were measured, which segment they are of, what was said."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grounding.features.background import NoObject
from grounding.features.registry import FEATURES, Feature, PatchFeatures, features_named
from grounding.symbols.compounds import expanded, head_of
from grounding.symbols.concepts import SegmentTable
from grounding.symbols.records import LabelledPatch, PatchDecision
from grounding.types import FloatArray

_MEASURED = 0.8  # of the patches must have a feature for it to be learnt from


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Corpus:
    """The patches that could be measured, N of them in S segments.

    Attributes:
        patches: as given.
        features: the D features that all of them have.
        values: (N, D) in the features' own units.
        weights: (N,).
        segment: (N,) index of the segment.
        said: (S) words of each segment, with the heads of compounds.
        unusable: decisions on the patches that were left out.
    """

    patches: tuple[LabelledPatch, ...]
    features: tuple[Feature, ...]
    values: FloatArray
    weights: FloatArray
    segment: NDArray[np.intp]
    said: tuple[tuple[str, ...], ...]
    unusable: tuple[PatchDecision, ...]

    @property
    def words(self) -> tuple[str, ...]:
        """All words, in alphabetical order."""
        return tuple(sorted({word for words in self.said for word in words}))


def gather(patches: Sequence[LabelledPatch], names: Sequence[str]) -> Corpus:
    """Return what can be learnt from.

    Args:
        patches: labelled patches.
        names: the features to use; empty takes all that are not raw, and a raw one only where
            nothing else of its family was measured.

    Raises:
        ConfigError: if a name is not in the registry.
    """
    weighty = [patch for patch in patches if patch.weight > 0]
    measured = [patch for patch in weighty if isinstance(patch.features, PatchFeatures)]
    rows = [patch.features.values for patch in weighty if isinstance(patch.features, PatchFeatures)]
    table = np.array(rows).reshape(len(rows), len(FEATURES))
    chosen = features_named(names) if names else _default_features(table)
    places = [list(FEATURES).index(feature.name) for feature in chosen]
    whole = np.flatnonzero(np.isfinite(table[:, places]).all(axis=1))
    kept = [measured[row] for row in whole]
    keys = [(patch.segment, patch.symbols) for patch in kept]
    order = {key: index for index, key in enumerate(dict.fromkeys(keys))}
    return Corpus(
        patches=tuple(kept),
        features=chosen,
        values=table[whole][:, places],
        weights=np.array([patch.weight for patch in kept]),
        segment=np.array([order[key] for key in keys], dtype=np.intp),
        said=tuple(expanded(words) for _, words in order),
        unusable=tuple(_unusable(patches, set(map(id, kept)))),
    )


def segment_table(corpus: Corpus, scaled: FloatArray) -> SegmentTable:
    """Return one row a segment for the search of concepts; compounds go with their heads."""
    centres = [np.median(scaled[corpus.segment == s], axis=0) for s in range(len(corpus.said))]
    return SegmentTable(
        centres=np.array(centres).reshape(len(corpus.said), scaled.shape[1]),
        families=tuple(feature.family for feature in corpus.features),
        bears={
            word: np.array([word in said for said in corpus.said])
            for word in corpus.words
            if head_of(word) is None
        },
    )


def _default_features(table: FloatArray) -> tuple[Feature, ...]:
    if not len(table):
        return tuple(feature for feature in FEATURES.values() if not feature.raw)
    share = np.isfinite(table).mean(axis=0)
    there = [f for f, s in zip(FEATURES.values(), share, strict=True) if s >= _MEASURED]
    served = {feature.family for feature in there if not feature.raw}
    return tuple(f for f in there if not f.raw or f.family not in served)


def _unusable(patches: Sequence[LabelledPatch], kept: set[int]) -> list[PatchDecision]:
    found: list[PatchDecision] = []
    for patch in patches:
        if id(patch) in kept:
            continue
        features, reason = patch.features, "a feature could not be measured"
        if patch.weight <= 0:
            reason = "its label has no weight"
        if isinstance(features, NoObject):
            reason = str(features.reason)
        found.extend(
            PatchDecision(
                patch=patch.name, segment=patch.segment, symbol=word, kept=False, reason=reason
            )
            for word in expanded(patch.symbols)
        )
    return found
