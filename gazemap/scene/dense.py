"""The surroundings as a surface, from a moving camera alone.

Depth by plane sweeps between views, kept where views agree; planes where there was nothing to
compare (`completion`).
"""

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np

from gazemap.geometry.arrays import FloatArray
from gazemap.scene.completion import planes_between
from gazemap.scene.config import SweepConfig
from gazemap.scene.sweep import (
    Float32Array,
    StillView,
    points_of,
    seen_depth,
    sweep_depth,
)
from gazemap.scene.viewpoints import depth_range, partners

_EDGE = np.ones((3, 3), np.uint8)
_EDGE_STEP = 1.06  # nearest to farthest depth around a pixel; more is an edge, which smears
_NOWHERE = 1e9
_THREADS = min(os.cpu_count() or 1, 4)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DenseView:
    """A view with its depth.

    Attributes:
        view: the view.
        measured: (h, w) depth on which views agree; NaN elsewhere.
        fitted: (h, w) depth of planes where nothing could be measured; NaN elsewhere.
    """

    view: StillView
    measured: Float32Array
    fitted: Float32Array


def dense_views(
    views: tuple[StillView, ...],
    points_world: FloatArray,
    *,
    reach: float,
    config: SweepConfig,
) -> list[DenseView]:
    """Return the depth of the first `config.views` views where others confirm it.

    Args:
        views: of a scene that mostly stands still; the later ones are there to compare with.
        points_world: (M, 3) the sparse map, which says how far things are.
        reach: typical distance of what the views see.
        config: settings.
    """
    chosen = views[: config.views]
    sweep = partial(_swept, views=views, points_world=points_world, reach=reach, config=config)
    with ThreadPoolExecutor(_THREADS) as pool:  # arithmetic on whole images lets others run
        depths = list(pool.map(sweep, range(len(chosen))))
    kept = [_agreed(k, chosen, depths, config) for k in range(len(chosen))]
    rng = np.random.default_rng(0)
    dense = []
    for k, view in enumerate(chosen):
        others = [views[j] for j in partners(k, views, reach=reach, count=config.partners)]
        planes = planes_between(view, kept[k], others, config=config, rng=rng)
        fitted = _not_seen_through(k, chosen, kept, planes)
        dense.append(DenseView(view=view, measured=kept[k], fitted=fitted))
    return dense


def _swept(
    k: int,
    *,
    views: tuple[StillView, ...],
    points_world: FloatArray,
    reach: float,
    config: SweepConfig,
) -> Float32Array:
    nothing = np.full(views[k].shape, np.nan, dtype=np.float32)
    between = depth_range(views[k], points_world)
    others = [views[j] for j in partners(k, views, reach=reach, count=config.partners)]
    if between is None or len(others) < 2:
        return nothing
    depth = sweep_depth(views[k], others, near=between[0], far=between[1], config=config)
    return _without_edges(depth)


def _without_edges(depth: Float32Array) -> Float32Array:
    """Return a depth image (h, w) without its edges, where patches show two things at once."""
    known = np.isfinite(depth)
    nearest = cv2.erode(np.where(known, depth, _NOWHERE).astype(np.float32), _EDGE)
    farthest = cv2.dilate(np.where(known, depth, 0).astype(np.float32), _EDGE)
    return np.where(known & (farthest < _EDGE_STEP * nearest), depth, np.nan).astype(np.float32)


def _agreed(
    k: int, views: tuple[StillView, ...], depths: list[Float32Array], config: SweepConfig
) -> Float32Array:
    """Return a view's depth where enough other views have a surface at the same place."""
    points = points_of(views[k], depths[k])
    agreeing = np.zeros(views[k].shape, dtype=np.int64)
    for j, other in enumerate(views):
        if j != k:
            far, there = seen_depth(other, depths[j], points)
            with np.errstate(invalid="ignore"):
                agreeing += np.abs(far - there) < config.tolerance * far
    return np.where(agreeing >= config.min_agreeing, depths[k], np.nan).astype(np.float32)


def _not_seen_through(
    k: int, views: tuple[StillView, ...], measured: list[Float32Array], fitted: Float32Array
) -> Float32Array:
    """Return fitted depth without what other views have seen something behind of."""
    points = points_of(views[k], fitted)
    through = np.zeros(views[k].shape, dtype=np.int64)
    for j, other in enumerate(views):
        if j != k:
            far, there = seen_depth(other, measured[j], points)
            with np.errstate(invalid="ignore"):
                through += there > 1.05 * far
    return np.where(through == 0, fitted, np.nan).astype(np.float32)
