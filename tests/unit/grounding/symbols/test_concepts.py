"""Which words describe the same features, from tables of segments."""

import numpy as np

from grounding.features.registry import Family
from grounding.symbols.concepts import SegmentTable, find_concepts

FAMILIES = (Family.COLOUR, Family.SIZE, Family.SHAPE)
PLACE = {"red": 0.0, "blue": 20.0, "yellow": -20.0, "cell": -15.0, "block": 0.0, "cube": 15.0}


def _table(said: list[tuple[str, ...]], centres: list[tuple[float, float, float]]) -> SegmentTable:
    words = sorted({word for each in said for word in each})
    rng = np.random.default_rng(4)
    return SegmentTable(
        centres=np.array(centres) + rng.normal(0, 0.5, (len(said), 3)),
        families=FAMILIES,
        bears={word: np.array([word in each for each in said]) for word in words},
    )


def test_a_shape_that_was_mostly_seen_in_one_colour_describes_no_colour():
    said = [
        *[("red", "cube")] * 6,
        ("blue", "cube"),
        *[("blue", "cell"), ("yellow", "cell")] * 2,
        *[("red", "block"), ("blue", "block"), ("yellow", "block")],
    ]
    centres = [(PLACE[colour], PLACE[shape], PLACE[shape]) for colour, shape in said]
    found = find_concepts(_table(said, centres), np.random.default_rng(0))
    described = {concept.words: set(concept.families) for concept in found}
    assert described == {
        ("block", "cell", "cube"): {Family.SIZE, Family.SHAPE},
        ("blue", "red", "yellow"): {Family.COLOUR},
    }


def test_names_that_stand_alone_keep_all_that_they_describe():
    said = [("red", "cube"), ("blue", "cell"), ("yellow", "block"), ("red", "cell")] * 3
    said += [("blue", "block"), ("yellow", "cube")] * 3
    centres = [(PLACE[colour], PLACE[shape], PLACE[shape]) for colour, shape in said]
    names = [("banana",)] * 6 + [("plum",)] * 6
    centres += [(-20.0, 30.0, 30.0)] * 6 + [(40.0, -30.0, -30.0)] * 6
    found = find_concepts(_table([*said, *names], centres), np.random.default_rng(0))
    described = {concept.words: set(concept.families) for concept in found}
    assert described[("blue", "red", "yellow")] == {Family.COLOUR}
    assert {Family.COLOUR, Family.SHAPE} <= described[("banana", "plum")]
