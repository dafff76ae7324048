"""Words of the simulated table: colours, shapes and relations, and how they look."""

from dataclasses import dataclass
from enum import StrEnum


class Relation(StrEnum):
    """Where a thing is put, as the wearer sees it: left is -x, in front is -y."""

    ON_TOP_OF = "on-top-of"
    LEFT_OF = "left-of"
    RIGHT_OF = "right-of"
    IN_FRONT_OF = "in-front-of"
    BEHIND = "behind"

    @property
    def phrase(self) -> str:
        """The relation as it is said."""
        words = self.value.replace("-", " ")
        return f"to the {words}" if self in (Relation.LEFT_OF, Relation.RIGHT_OF) else words

    @property
    def direction(self) -> tuple[float, float]:
        """Unit step (x, y) in world from the reference; zero for on top."""
        steps = {
            Relation.ON_TOP_OF: (0.0, 0.0),
            Relation.LEFT_OF: (-1.0, 0.0),
            Relation.RIGHT_OF: (1.0, 0.0),
            Relation.IN_FRONT_OF: (0.0, -1.0),
            Relation.BEHIND: (0.0, 1.0),
        }
        return steps[self]


@dataclass(frozen=True, slots=True, kw_only=True)
class Shape:
    """A shape: its usual size (x, y, z) in metres, scaled a little from thing to thing."""

    size_m: tuple[float, float, float]


COLOURS_BGR: dict[str, tuple[int, int, int]] = {
    "red": (44, 34, 208),
    "blue": (196, 72, 32),
    "yellow": (34, 200, 240),
    "green": (62, 156, 44),
    "orange": (24, 122, 240),
    "purple": (150, 46, 122),
    "white": (232, 236, 238),
    "black": (34, 32, 30),
    "pink": (178, 130, 244),
    "cyan": (206, 186, 44),
}
SHAPES: dict[str, Shape] = {
    "cube": Shape(size_m=(0.048, 0.048, 0.048)),
    "block": Shape(size_m=(0.072, 0.034, 0.034)),
    "cell": Shape(size_m=(0.030, 0.030, 0.018)),
    "brick": Shape(size_m=(0.080, 0.040, 0.024)),
    "tile": Shape(size_m=(0.052, 0.052, 0.012)),
    "pillar": Shape(size_m=(0.030, 0.030, 0.064)),
    "plank": Shape(size_m=(0.110, 0.026, 0.014)),
}
PICK_VERBS = ("get", "grab", "pick up", "take")
PUT_VERBS = ("put", "place")
