"""The plane a wearer works at, found as the one that most of a map lies on."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray

_TRIES: Final = 500
# A point lies on the plane within this share of the usual distance from the cameras.
_TOLERANCE: Final = 0.012
_MIN_SHARE: Final = 0.3
_MIN_POINTS: Final = 30
# The camera's up leans by as much as the head looks down; a wall leans by a right angle and more.
_MIN_UPRIGHT: Final = float(np.cos(np.radians(80.0)))
_REFITS: Final = 5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Support:
    """A plane in the map: `normal_map @ p == offset`, the cameras where it is larger.

    Attributes:
        normal_map: unit normal (3,), towards the cameras.
        offset: its distance from the map's origin along the normal.
    """

    normal_map: FloatArray
    offset: float


def find_support(
    points_map: FloatArray,
    *,
    origins_map: FloatArray,
    up_map: FloatArray,
    rng: np.random.Generator,
) -> Support | None:
    """Return the level plane that most points lie on; None where too few share one.

    Args:
        points_map: (M, 3) the map's points.
        origins_map: (F, 3) where the cameras were.
        up_map: (3,) the cameras' mean up, which tells a table from a wall.
        rng: draws the planes that are tried.

    Source:
        Fischler and Bolles 1981, refitted by principal components.
    """
    if len(points_map) < _MIN_POINTS:
        return None
    centre = np.median(origins_map, axis=0)
    tolerance = _TOLERANCE * float(np.median(np.linalg.norm(points_map - centre, axis=1)))
    best = np.zeros(len(points_map), dtype=bool)
    for chosen in rng.integers(len(points_map), size=(_TRIES, 3)):
        support = _oriented(points_map[chosen], centre)
        if support is None or support.normal_map @ up_map < _MIN_UPRIGHT:
            continue
        near = _near(points_map, support, tolerance)
        if near.sum() > best.sum():
            best = near
    if best.sum() < max(_MIN_POINTS, _MIN_SHARE * len(points_map)):
        return None
    fitted: Support | None = None
    for _ in range(_REFITS):
        fitted = _oriented(points_map[best], centre)
        if fitted is None:
            return None
        best = _near(points_map, fitted, tolerance)
    return fitted


def _near(points_map: FloatArray, support: Support, tolerance: float) -> BoolArray:
    return np.asarray(np.abs(points_map @ support.normal_map - support.offset) < tolerance)


def _oriented(points_map: FloatArray, centre: FloatArray) -> Support | None:
    """Return the plane of least squares through points (N, 3); None if they lie on a line."""
    mean = points_map.mean(axis=0)
    _, spread, axes = np.linalg.svd(points_map - mean, full_matrices=False)
    if spread[1] < 1e-6 * max(spread[0], 1e-300):
        return None
    normal = axes[2] if axes[2] @ (centre - mean) > 0 else -axes[2]
    return Support(normal_map=normal, offset=float(normal @ mean))
