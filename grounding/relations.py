"""What a location symbol says: its relation, its landmarks, and where that is.

A relation is a normal distribution of the offset from the landmark's centre to that of the thing
that was put, in the wearer's axes (right, forward, up). It starts from a built-in prior and is
learnt from what was seen; with no demonstration the prior is used and says so.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from grounding.types import FloatArray

# Longest first: "on-top-of" before "on". What follows is the landmark.
_PREFIXES: Final[tuple[tuple[str, str], ...]] = (
    ("on-left-side-of", "left-of"),
    ("on-right-side-of", "right-of"),
    ("to-left-of", "left-of"),
    ("on-left-of", "left-of"),
    ("left-of", "left-of"),
    ("to-right-of", "right-of"),
    ("on-right-of", "right-of"),
    ("right-of", "right-of"),
    ("on-top-of", "on-top-of"),
    ("in-front-of", "in-front-of"),
    ("in-middle-of", "on-top-of"),
    ("next-to", "near"),
    ("close-to", "near"),
    ("in-back-of", "behind"),
    ("behind", "behind"),
    ("between", "between"),
    ("beside", "near"),
    ("near", "near"),
    ("by", "near"),
    ("onto", "on-top-of"),
    ("upon", "on-top-of"),
    ("atop", "on-top-of"),
    ("on", "on-top-of"),
    ("into", "in"),
    ("inside", "in"),
    ("in", "in"),
    ("over", "on-top-of"),
    ("above", "on-top-of"),
    ("from", "from"),
    ("out-of", "from"),
    ("off", "from"),
    ("under", "under"),
    ("below", "under"),
    ("to", "near"),
)
_FORMS_WITHOUT_LANDMARK: Final = ("-location",)


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """A location symbol taken apart.

    Attributes:
        relation: its normal form (`left-of`, `on-top-of`, ...), or None for the target's own place.
        landmarks: the words of each thing it refers to; two for "between", none for an own place.
    """

    relation: str | None
    landmarks: tuple[tuple[str, ...], ...]


def parse_location(symbol: str) -> Place:
    """Take a location symbol apart; a form that is not known has no relation and no landmark."""
    if symbol.endswith(_FORMS_WITHOUT_LANDMARK):
        return Place(relation=None, landmarks=())
    for prefix, relation in _PREFIXES:
        if symbol.startswith(prefix + "-"):
            rest = symbol.removeprefix(prefix + "-")
            parts = rest.split("-and-") if relation == "between" else [rest]
            return Place(relation=relation, landmarks=tuple(tuple(p.split("-")) for p in parts))
    return Place(relation=None, landmarks=())


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OffsetPrior:
    """A relation's offset before any demonstration.

    Attributes:
        mean_m: (3,) right, forward, up.
        sigma_m: (3,) standard deviations.
    """

    mean_m: FloatArray
    sigma_m: FloatArray


def _prior(right: float, forward: float, up: float, *, sigma: Sequence[float]) -> OffsetPrior:
    return OffsetPrior(mean_m=np.array([right, forward, up]), sigma_m=np.array(sigma))


# Hand-sized things on a table stand about a decimetre apart, centre to centre.
_BESIDE_M: Final = 0.10
PRIORS: Final[dict[str, OffsetPrior]] = {
    "left-of": _prior(-_BESIDE_M, 0.0, 0.0, sigma=(0.04, 0.03, 0.02)),
    "right-of": _prior(_BESIDE_M, 0.0, 0.0, sigma=(0.04, 0.03, 0.02)),
    "in-front-of": _prior(0.0, -_BESIDE_M, 0.0, sigma=(0.03, 0.04, 0.02)),
    "behind": _prior(0.0, _BESIDE_M, 0.0, sigma=(0.03, 0.04, 0.02)),
    "on-top-of": _prior(0.0, 0.0, 0.04, sigma=(0.012, 0.012, 0.02)),
    "in": _prior(0.0, 0.0, 0.0, sigma=(0.03, 0.03, 0.03)),
    "under": _prior(0.0, 0.0, -0.04, sigma=(0.02, 0.02, 0.02)),
    "between": _prior(0.0, 0.0, 0.0, sigma=(0.03, 0.03, 0.02)),
    "near": _prior(0.0, 0.0, 0.0, sigma=(0.08, 0.08, 0.02)),
}


def wearer_axes(heading_rad: float) -> FloatArray:
    """Return (3, 3): the rows are right, forward and up of the wearer, in world."""
    c, s = np.cos(heading_rad), np.sin(heading_rad)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
