"""The paper's experiment on simulated patches.

2000 training patches of red, blue and yellow cells, blocks and cubes come in segments, each thing
in its turn. Of every four segments one is labelled wrong, as an alignment of gaze with
instructions would: that rate is kept, not drawn, for two-sigma cleaning tips over near it. 48 test
objects stand in three parts of 16: what was seen; close to it (a known colour on a new shape or the
other way); far from it. The numbers of known and unknown things are those of the paper's tables.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Final, TypeVar

import numpy as np

from grounding.features.registry import PatchFeatures, extract_features
from grounding.symbols.classify import Classifier
from grounding.symbols.model import SymbolModel
from grounding.symbols.records import LabelledPatch
from grounding.symbols.simulated import Scene, Shape, Thing, draw_patch

COLOUR_WORDS: Final = ("red", "blue", "yellow")
SHAPE_WORDS: Final = ("cell", "block", "cube")
NEW_COLOURS: Final = ("green", "purple", "white", "black", "cyan", "pink")
# New shapes of about the footprint of the known ones, as the toys of one set have
NEW_SHAPES: Final = (
    (Shape.DISC, 1.0),
    (Shape.COIN, 0.9),
    (Shape.RING, 0.7),
    (Shape.CROSS, 0.75),
    (Shape.BAR, 1.0),
    (Shape.TRIANGLE, 1.2),
    (Shape.WEDGE, 1.0),
)
_THINGS: Final = tuple(product(COLOUR_WORDS, SHAPE_WORDS))
_T = TypeVar("_T")
UNKNOWN: Final = "unknown"
TRAINING_PATCHES: Final = 2000
_RIGHT_LABELS: Final = (True, True, True, False)
# Each row: the part, its objects, whether their colour is known, whether their shape is
_PARTS: Final = (
    ("seen", 16, True, True),
    ("close", 6, False, True),
    ("close", 10, True, False),
    ("far", 6, False, True),
    ("far", 2, False, False),
    ("far", 8, True, False),
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TestObject:
    """An object to classify; `colour` and `shape` are words, or unknown."""

    part: str
    colour: str
    shape: str
    features: PatchFeatures | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A confusion table of one concept: (true word, said word) -> objects."""

    words: tuple[str, ...]
    counts: dict[tuple[str, str], int]

    def right(self, *, known: bool | None = None) -> tuple[int, int]:
        """Return how many are right, of how many: all, the known or the unknown ones."""
        chosen = {
            key: count
            for key, count in self.counts.items()
            if known is None or known == (key[0] != UNKNOWN)
        }
        right = sum(count for (true, said), count in chosen.items() if true == said)
        return right, sum(chosen.values())


# Recomputed from the paper's two confusion tables: (right, of) over all, known, unknown
PUBLISHED: Final = {
    "colour": ((50, 53), (37, 39), (13, 14)),
    "shape": ((27, 48), (23, 28), (4, 20)),
}


def training_patches(
    rng: np.random.Generator, *, count: int = TRAINING_PATCHES, scene: Scene | None = None
) -> Iterator[LabelledPatch]:
    """Yield simulated patches in segments of 8 to 24, a quarter of the segments labelled wrong."""
    scene = scene or Scene()
    things, right = _in_rounds(_THINGS, rng), _in_rounds(_RIGHT_LABELS, rng)
    made = 0
    segment = 0
    while made < count:
        true = next(things)
        said = true if next(right) else _another(true, rng)
        for _ in range(min(count - made, int(rng.integers(8, 25)))):
            patch = draw_patch(Thing(colour=true[0], shape=Shape(true[1])), scene, rng)
            yield LabelledPatch(
                features=extract_features(patch, mm_per_px=scene.mm_per_px),
                symbols=said,
                segment=str(segment),
                name=f"{made:04d}",
            )
            made += 1
        segment += 1


def objects_to_classify(
    rng: np.random.Generator, *, scene: Scene | None = None
) -> list[TestObject]:
    """Return the 48 objects."""
    scene = scene or Scene()
    objects = []
    for part, count, known_colour, known_shape in _PARTS:
        for number in range(count):
            colour = _turn(COLOUR_WORDS if known_colour else NEW_COLOURS, number)
            known = _turn(SHAPE_WORDS, number // len(COLOUR_WORDS))
            shape, size = (Shape(known), 1.0) if known_shape else _turn(NEW_SHAPES, number)
            patch = draw_patch(Thing(colour=colour, shape=shape, size=size), scene, rng)
            features = extract_features(patch, mm_per_px=scene.mm_per_px)
            objects.append(
                TestObject(
                    part=part,
                    colour=colour if known_colour else UNKNOWN,
                    shape=str(shape) if known_shape else UNKNOWN,
                    features=features if isinstance(features, PatchFeatures) else None,
                )
            )
    return objects


def confusion(model: SymbolModel, objects: list[TestObject]) -> dict[str, Table]:
    """Return the confusion tables of colour and shape.

    A concept's answer is the known word among its own, and unknown without one.
    """
    classifier = Classifier(model)
    counts: dict[str, Counter[tuple[str, str]]] = {"colour": Counter(), "shape": Counter()}
    for each in objects:
        found = [] if each.features is None else classifier.classify(each.features)
        said = {answer.symbol: answer.score for answer in found if answer.known}
        for concept, words, true in (
            ("colour", COLOUR_WORDS, each.colour),
            ("shape", SHAPE_WORDS, each.shape),
        ):
            answers = [word for word in words if word in said]
            best = max(answers, key=lambda word: said[word], default=UNKNOWN)
            counts[concept][true, best] += 1
    return {
        "colour": Table(words=(*COLOUR_WORDS, UNKNOWN), counts=dict(counts["colour"])),
        "shape": Table(words=(*SHAPE_WORDS, UNKNOWN), counts=dict(counts["shape"])),
    }


def _another(true: tuple[str, str], rng: np.random.Generator) -> tuple[str, str]:
    """Return the words of another object on the table."""
    others = [thing for thing in _THINGS if thing != true]
    return others[int(rng.integers(len(others)))]


def _in_rounds(values: tuple[_T, ...], rng: np.random.Generator) -> Iterator[_T]:
    """Yield values for ever: all of them in random order, then all of them anew."""
    while True:
        yield from (values[place] for place in rng.permutation(len(values)))


def _turn(things: tuple[_T, ...], number: int) -> _T:
    return things[number % len(things)]
