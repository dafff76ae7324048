"""What the words of one session mean, from the patches that its instructions gave."""

from collections.abc import Iterable

from grounding.features.registry import extract_features
from grounding.patches.patch import Patch
from grounding.symbols.learn import fit_symbols
from grounding.symbols.model import SymbolModel
from grounding.symbols.records import LabelledPatch, SymbolConfig


def learn_from_patches(patches: Iterable[Patch], config: SymbolConfig) -> SymbolModel:
    """Learn words from the patches that were kept; an instruction is one labelling decision."""
    labelled = [
        LabelledPatch(
            features=extract_features(
                each.image_bgr, mm_per_px=each.mm_per_px, height_mm=each.height_mm
            ),
            symbols=each.symbols,
            segment=str(each.instruction),
            weight=each.weight,
            name=each.name,
        )
        for each in patches
        if each.kept and each.image_bgr is not None
    ]
    return fit_symbols(labelled, config)
