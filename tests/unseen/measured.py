"""From sets of patches to the figures that the sample's scoring gives."""

import zlib

import numpy as np

from grounding.features.registry import PatchFeatures, extract_features
from grounding.symbols.classify import Classifier
from grounding.symbols.learn import fit_symbols
from grounding.symbols.records import LabelledPatch, SymbolConfig
from tests.unseen.render import Look, Shot
from tests.unseen.sets import UNKNOWN, WORDS, table_of, to_learn, to_name

Figures = dict[tuple[str, str], float]


def figures(name: str, look: Look, *, patches: int, turns: int, seed: int = 0) -> Figures:
    """Return (test, kind) -> share of right answers, after learning under the same look.

    Args:
        name: of the look; draws the table and the things.
        look: table, light, camera.
        patches: to learn from, a quarter of the segments labelled wrong.
        turns: how many times each thing is asked for.
        seed: for another table and other things under the same look.
    """
    rng = np.random.default_rng([zlib.crc32(name.encode()), seed])
    picture = table_of(look, rng)
    learnt = [
        LabelledPatch(features=_measured(each.shot), symbols=each.said, segment=each.segment)
        for each in to_learn(look, picture, rng, count=patches)
    ]
    classifier = Classifier(fit_symbols(learnt, SymbolConfig()))
    right: dict[tuple[str, str], list[bool]] = {}
    for asked in to_name(look, picture, rng, turns=turns):
        features = _measured(asked.shot)
        found = classifier.classify(features) if isinstance(features, PatchFeatures) else []
        said = {each.symbol for each in found if each.known} & WORDS[asked.test]
        right.setdefault((asked.test, asked.kind), []).append(said == {asked.expected} - {UNKNOWN})
    return {key: float(np.mean(each)) for key, each in right.items()}


def _measured(shot: Shot):
    return extract_features(shot.image_bgr, mm_per_px=shot.mm_per_px)
