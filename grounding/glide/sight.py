"""What a look says of a position: the residual between a gaze ray and a point, in metres.

With the ray's origin the residual lies in the plane across the ray, where the gaze error is;
without it the hit point is compared in the table's plane.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grounding.types import BoolArray, FixationObservation, FloatArray

# A hit lies on the near side of a thing, its middle behind: half a hand-sized thing.
_SURFACE_TO_MIDDLE_M = 0.02


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sights:
    """All looks of a session as arrays, in time order.

    Attributes:
        start_s: (T,) seconds from the first look.
        end_s: (T,) seconds from the first look.
        seen: (T,) whether the gaze met anything.
        has_ray: (T,) whether the ray's origin is known.
        origin: (T, 3) the ray's origin; the hit point where it is not known.
        point: (T, 3) the hit point; zero where nothing was met.
        across: (T, 2, 3) the two directions of the residual, to the right and up.
        cov: (T, 2, 2) of the measurement along them, m^2.
        range_m: (T,) distance of the hit point from the origin; 0 without one.
    """

    start_s: FloatArray
    end_s: FloatArray
    seen: BoolArray
    has_ray: BoolArray
    origin: FloatArray
    point: FloatArray
    across: FloatArray
    cov: FloatArray
    range_m: FloatArray

    @property
    def count(self) -> int:
        """The number of looks."""
        return len(self.start_s)

    @property
    def mid_s(self) -> FloatArray:
        """The middles of the looks (T,), seconds from the first."""
        return 0.5 * (self.start_s + self.end_s)


def sights_of(fixations: Sequence[FixationObservation], *, unit_m: float = 1.0) -> Sights:
    """Bring fixations, in time order, into arrays.

    Args:
        fixations: the session's fixations.
        unit_m: one metre in world units.

    Returns:
        The looks; times count from the first.
    """
    zero_ns = fixations[0].start_ns if fixations else 0
    rows = [_across(each, unit_m=unit_m) for each in fixations]
    points = [np.zeros(3) if f.point_world is None else f.point_world for f in fixations]
    origins = [
        p if f.origin_world is None else f.origin_world
        for f, p in zip(fixations, points, strict=True)
    ]
    point = np.array(points, dtype=np.float64).reshape(-1, 3)
    origin = np.array(origins, dtype=np.float64).reshape(-1, 3)
    return Sights(
        start_s=np.array([(f.start_ns - zero_ns) / 1e9 for f in fixations], dtype=np.float64),
        end_s=np.array([(f.end_ns - zero_ns) / 1e9 for f in fixations], dtype=np.float64),
        seen=np.array([f.point_world is not None for f in fixations], dtype=np.bool_),
        has_ray=np.array([f.origin_world is not None for f in fixations], dtype=np.bool_),
        origin=origin,
        point=point,
        across=np.array([r[0] for r in rows], dtype=np.float64).reshape(-1, 2, 3),
        cov=np.array([r[1] for r in rows], dtype=np.float64).reshape(-1, 2, 2),
        range_m=np.linalg.norm(point - origin, axis=1),
    )


def _across(fixation: FixationObservation, *, unit_m: float) -> tuple[FloatArray, FloatArray]:
    across = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    if fixation.point_world is None or fixation.cov_world is None:
        return across, np.eye(2)
    extra = (_SURFACE_TO_MIDDLE_M * unit_m) ** 2
    if fixation.origin_world is not None:
        ray = fixation.point_world - fixation.origin_world
        ray = ray / max(float(np.linalg.norm(ray)), 1e-9)
        right = np.cross(ray, [0.0, 0.0, 1.0])
        size = float(np.linalg.norm(right))
        right = right / size if size > 1e-6 else np.array([1.0, 0.0, 0.0])
        across, extra = np.stack([right, np.cross(right, ray)]), 0.0
    return across, across @ fixation.cov_world @ across.T + extra * np.eye(2)


def log_density(
    sights: Sights, points: FloatArray, covs: FloatArray, *, offset_rad: FloatArray, scale: float
) -> FloatArray:
    """Return the log density (T, P) of every look if it was meant for every point.

    Args:
        sights: T looks.
        points: (P, 3) in world.
        covs: (P, 3, 3) of the points, the spread of aiming on the thing included.
        offset_rad: (2,) gaze offset still in the looks, to the right and up.
        scale: factor on the measurement's standard deviations.

    Returns:
        Natural logarithms per m^2; -inf for a look that met nothing.
    """
    residual = residuals(sights, points, offset_rad=offset_rad)  # (T, P, 2)
    spread = np.einsum("tac,pcd,tbd->tpab", sights.across, covs, sights.across)
    spread = spread + (scale**2) * sights.cov[:, None]
    a, b, d = spread[..., 0, 0], spread[..., 0, 1], spread[..., 1, 1]
    det = a * d - b * b
    x, y = residual[..., 0], residual[..., 1]
    squared = (d * x * x - 2 * b * x * y + a * y * y) / det
    log = -0.5 * squared - 0.5 * np.log(det) - np.log(2 * np.pi)
    log[~sights.seen] = -np.inf
    return np.asarray(log, dtype=np.float64)


def residuals(sights: Sights, points: FloatArray, *, offset_rad: FloatArray) -> FloatArray:
    """Return how far each look went past each point: (T, P, 2) to the right and up, metres."""
    past = points[None, :, :] - sights.origin[:, None, :]  # (T, P, 3)
    far = np.linalg.norm(past, axis=2)
    off = -np.einsum("tac,tpc->tpa", sights.across, past)
    rays = np.where(sights.has_ray[:, None], far, 0.0)[..., None] * offset_rad
    return np.asarray(off - rays, dtype=np.float64)


def where_met(
    sights: Sights, height: float, *, offset_rad: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return where each look, its offset taken out, meets a level plane.

    Without a ray the hit point is lowered or raised to the plane as it stands.

    Args:
        sights: T looks.
        height: of the plane.
        offset_rad: (2,) gaze offset still in the looks, to the right and up.

    Returns:
        Points (T, 3), NaN for a look that met nothing, and covariances (T, 2, 2) in the plane.
    """
    ray = sights.point - sights.origin
    ray = ray - sights.range_m[:, None] * np.einsum("a,tac->tc", offset_rad, sights.across)
    down = np.where(np.abs(ray[:, 2]) > 1e-9, ray[:, 2], 1e-9)
    along = (height - sights.origin[:, 2]) / down
    use = sights.has_ray & (along > 0) & (along < 3.0)
    points = np.where(use[:, None], sights.origin + along[:, None] * ray, sights.point)
    points[:, 2] = height
    points[~sights.seen] = np.nan
    return points, _level_cov(sights, ray / down[:, None])


def _level_cov(sights: Sights, slope: FloatArray) -> FloatArray:
    """Carry the covariance across the ray into the level plane: (T, 2, 2)."""
    shear = np.zeros((sights.count, 2, 3))
    shear[:, 0, 0] = shear[:, 1, 1] = 1.0
    shear[:, :, 2] = np.where(sights.has_ray[:, None], -np.clip(slope[:, :2], -4.0, 4.0), 0.0)
    lift = np.einsum("tac,tbc->tab", shear, sights.across)
    return np.asarray(lift @ sights.cov @ np.swapaxes(lift, 1, 2), dtype=np.float64)
