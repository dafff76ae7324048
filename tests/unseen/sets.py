"""Sets of patches to learn from and to name, made as the sample beside the repository is."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import cycle, product

import numpy as np

from tests.unseen.render import Look, Shot, shoot
from tests.unseen.tables import Picture, table

COLOUR_WORDS = ("red", "blue", "yellow")
SHAPE_WORDS = ("cell", "block", "cube")
NEW_COLOURS = ("green", "purple", "white", "black", "cyan", "pink")
NEW_SHAPES = ("plate", "ball", "cross", "wedge", "ring", "bar", "tile", "coin")
ODD_COLOURS = ("brown", "grey", "orange")
ODD_SHAPES = ("triangle", "hexagon", "angle", "pen")
UNKNOWN = "unknown"
WORDS = {"colour": frozenset(COLOUR_WORDS), "shape": frozenset(SHAPE_WORDS)}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Labelled:
    """A patch to learn from."""

    shot: Shot
    said: tuple[str, str]
    segment: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Asked:
    """A patch to name: what is asked ("colour" or "shape"), of which kind, and the answer."""

    shot: Shot
    test: str
    kind: str
    expected: str


def table_of(look: Look, rng: np.random.Generator) -> Picture:
    """Return the table of a look."""
    return table(look.table, rng, stains=look.stains)


def to_learn(
    look: Look,
    picture: Picture,
    rng: np.random.Generator,
    *,
    count: int,
    wrong_rate: float = 0.25,
    empty_rate: float = 0.05,
) -> Iterator[Labelled]:
    """Yield patches in segments of 8 to 24; some segments are labelled as another thing."""
    things = [(colour, shape) for colour in COLOUR_WORDS for shape in SHAPE_WORDS]
    made = segment = 0
    order = rng.permutation(len(things))
    while made < count:
        true = things[order[segment % len(things)]]
        others = [thing for thing in things if thing != true]
        said = others[rng.integers(len(others))] if rng.random() < wrong_rate else true
        for _ in range(min(count - made, int(rng.integers(8, 25)))):
            seen = None if rng.random() < empty_rate else true
            yield Labelled(shot=shoot(seen, look, picture, rng), said=said, segment=str(segment))
            made += 1
        segment += 1


def to_name(
    look: Look, picture: Picture, rng: np.random.Generator, *, turns: int = 4
) -> Iterator[Asked]:
    """Yield what the sample asks for, and besides it kinds `odd` with other unknown things."""

    def ask(test: str, kind: str, thing: tuple[str, str], expected: str) -> Asked:
        return Asked(shot=shoot(thing, look, picture, rng), test=test, kind=kind, expected=expected)

    for turn in range(turns):
        for colour, (number, shape) in product(COLOUR_WORDS, enumerate(SHAPE_WORDS)):
            new = NEW_COLOURS[(turn * 3 + number) % len(NEW_COLOURS)]
            yield ask("colour", "seen", (colour, shape), colour)
            yield ask("colour", "close", (colour, "disc"), colour)
            yield ask("shape", "seen", (colour, shape), shape)
            yield ask("shape", "close", (new, shape), shape)
        shapes, colours = cycle(SHAPE_WORDS), cycle(COLOUR_WORDS)
        for colour in NEW_COLOURS:
            yield ask("colour", "far", (colour, "cube"), UNKNOWN)
        for shape in NEW_SHAPES:
            yield ask("shape", "far", (next(colours), shape), UNKNOWN)
        for colour in ODD_COLOURS:
            yield ask("colour", "odd", (colour, next(shapes)), UNKNOWN)
        for shape in ODD_SHAPES:
            yield ask("shape", "odd", (next(colours), shape), UNKNOWN)
