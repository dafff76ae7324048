"""Patches that the product's own simulator did not draw: other tables, lights, cameras, noise.

The study (`-m slow`) learns and names under each look of `tests/unseen/looks.py`; the bars are
those of the sample less three points.
"""

import pytest

from tests.unseen.looks import LOOKS
from tests.unseen.measured import figures

BARS = {
    ("colour", "seen"): 0.96,
    ("colour", "close"): 0.87,
    ("colour", "far"): 0.92,
    ("shape", "seen"): 0.95,
    ("shape", "close"): 0.92,
    ("shape", "far"): 0.87,
}
# What no light can show: a black thing on a black table, colours that a glare has washed out.
LIMITS = {
    ("black, dim", "shape", "close"): 0.80,
    ("black, close camera", "shape", "close"): 0.80,
    ("steel, glossy", "colour", "far"): 0.40,
}


def below(name: str, *, patches: int, turns: int) -> dict[tuple[str, str], float]:
    """Return the figures that miss their bar under a look."""
    reached = figures(name, LOOKS[name], patches=patches, turns=turns)
    return {
        key: reached[key]
        for key, bar in BARS.items()
        if reached[key] < LIMITS.get((name, *key), bar)
    }


def test_another_table_and_a_hard_shadow_are_borne():
    assert below("planks, hard shadow", patches=220, turns=1) == {}


@pytest.mark.slow
@pytest.mark.parametrize("name", LOOKS)
def test_each_look_is_borne(name: str):
    assert below(name, patches=450, turns=4) == {}
