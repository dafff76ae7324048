"""Planes where a wall or a floor shows nothing to compare.

A smooth part of an image is filled in where what was measured around it lies on one plane, where
that support surrounds it, and where the other views do not contradict.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, IntArray
from gazemap.scene.config import SweepConfig
from gazemap.scene.sweep import Float32Array, StillView, points_of, seen_depth

_RING_PX = 9
_MIN_RING = 40
_MIN_PLANAR = 0.6
_TRIALS = 60
_SMOOTH_GREY = 6.0  # a pixel whose surroundings vary by less shows nothing to compare
_MAX_UNLIKE = 0.7  # variance of the difference between views, as a share of the variance in one


def planes_between(
    view: StillView,
    depth: Float32Array,
    others: list[StillView],
    *,
    config: SweepConfig,
    rng: np.random.Generator,
) -> Float32Array:
    """Return depth (h, w) of planes inside smooth parts of an image that have none; else NaN."""
    filled = np.full(view.shape, np.nan, dtype=np.float32)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(
        (_is_smooth(view) & np.isnan(depth)).astype(np.uint8), connectivity=4
    )
    points = points_of(view, depth)
    least, most = (
        share * labels.size for share in (config.min_fitted_share, config.max_fitted_share)
    )
    for label in range(1, count):
        if least <= stats[label, cv2.CC_STAT_AREA] <= most:
            region = labels == label
            plane = _plane_around(region, view, points, config=config, rng=rng)
            if plane is not None and _shows_itself(view, others, plane):
                filled[plane.pixels] = plane.depth
    return filled


def _is_smooth(view: StillView) -> BoolArray:
    grey, side = view.grey, (5, 5)
    variance = cv2.boxFilter(grey * grey, -1, side) - cv2.boxFilter(grey, -1, side) ** 2
    return np.asarray(variance < _SMOOTH_GREY**2)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Part:
    """A part of a plane in an image.

    Attributes:
        pixels: rows and columns (P,) of it.
        depth: (P,) along the optical axis.
    """

    pixels: tuple[IntArray, IntArray]
    depth: FloatArray


def _plane_around(
    region: BoolArray,
    view: StillView,
    points: FloatArray,
    *,
    config: SweepConfig,
    rng: np.random.Generator,
) -> _Part | None:
    """Return a region (h, w) as part of the plane through the points (h, w, 3) around it.

    None where they are on no plane. Only what lies between supporting points is filled: beyond
    them nothing was seen.
    """
    kernel = np.ones((2 * _RING_PX + 1, 2 * _RING_PX + 1), dtype=np.uint8)
    ring = cv2.dilate(region.astype(np.uint8), kernel).astype(bool) & np.isfinite(points[..., 0])
    around = points[ring]
    if len(around) < _MIN_RING:
        return None
    distances = (around - view.p_world_cam) @ view.R_world_cam[:, 2]
    tolerance = config.plane_tolerance * float(np.median(distances))
    plane, on_plane = fit_plane(around, tolerance=tolerance, rng=rng)
    if on_plane.mean() < _MIN_PLANAR:
        return None
    supports = np.zeros(region.shape, dtype=bool)
    supports[ring] = on_plane
    v, u = np.nonzero(_enclosed(region, supports))
    rays = np.column_stack([u, v, np.ones(len(u))]) @ np.linalg.inv(view.K).T @ view.R_world_cam.T
    with np.errstate(divide="ignore"):
        depth = (plane[3] - view.p_world_cam @ plane[:3]) / (rays @ plane[:3])
    fits = (depth > 0.8 * distances.min()) & (depth < 1.2 * distances.max())
    return _Part(pixels=(v[fits], u[fits]), depth=depth[fits])


def _shows_itself(view: StillView, others: list[StillView], part: _Part) -> bool:
    """Whether the other views see on the plane what this one sees, faint as it may be.

    Shading and grain too weak for single patches still tell over a whole part: a floor behind
    two table edges differs between views although the plane through the edges would enclose it.
    """
    here = view.grey[part.pixels]
    if len(here) < _MIN_RING:
        return False
    structure = max(float(here.var()), 1e-6)
    image = np.full(view.shape, np.nan, dtype=np.float32)
    image[part.pixels] = part.depth
    points = points_of(view, image)[part.pixels]
    unlike = []
    for other in others:
        _, there = seen_depth(other, other.grey, points)
        known = np.isfinite(there)
        if known.mean() > 0.5:
            away = here[known] - there[known]
            unlike.append(float(away.var()) / structure)
    return len(unlike) > 0 and float(np.median(unlike)) < _MAX_UNLIKE


def _enclosed(region: BoolArray, supports: BoolArray) -> BoolArray:
    """Return the pixels (h, w) of a region that meet support on at least three of four sides.

    What a region borders on one side only may end there, with the region far behind.
    """
    rows, columns = (np.flatnonzero(region.any(axis=k)) for k in (1, 0))
    part = np.s_[
        max(rows[0] - _RING_PX, 0) : rows[-1] + _RING_PX + 1,
        max(columns[0] - _RING_PX, 0) : columns[-1] + _RING_PX + 1,
    ]
    inner = region[part]
    near = cv2.dilate(supports[part].astype(np.uint8), np.ones((7, 7), np.uint8)).astype(bool)
    met = np.zeros(inner.shape, dtype=np.int64)
    for turns in range(4):
        met += np.rot90(_met_above(np.rot90(inner, turns), np.rot90(near, turns)), -turns)
    enclosed = np.zeros(region.shape, dtype=bool)
    enclosed[part] = inner & (met >= 3)
    return enclosed


def _met_above(region: BoolArray, supports: BoolArray) -> BoolArray:
    """Return whether the first pixel above each (h, w) that is out of the region is a support."""
    met = supports & ~region
    for row in range(1, len(met)):
        met[row] = np.where(region[row], met[row - 1], met[row])
    return np.asarray(met)


def fit_plane(
    points: FloatArray, *, tolerance: float, rng: np.random.Generator
) -> tuple[FloatArray, BoolArray]:
    """Return the plane n . x = d as (n, d) of most of the points (N, 3), and which lie on it.

    Source:
        Fischler and Bolles 1981 (RANSAC), then least squares over the inliers, twice.
    """
    best = np.zeros(len(points), dtype=bool)
    for _ in range(_TRIALS):
        a, b, c = points[rng.choice(len(points), 3, replace=False)]
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal)
        if length > 1e-12:
            close = np.abs((points - a) @ (normal / length)) < tolerance
            best = close if close.sum() > best.sum() else best
    plane = np.array([0.0, 0.0, 1.0, 0.0])
    for _ in range(2):
        if best.sum() < 3:
            break
        centre = points[best].mean(axis=0)
        normal = np.linalg.svd(points[best] - centre, full_matrices=False)[2][2]
        plane = np.append(normal, normal @ centre)
        best = np.abs(points @ normal - plane[3]) < tolerance
    return plane, best
