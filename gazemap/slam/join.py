"""Parts of a recording that no corner connects, joined by what they look like.

After a black-out, or a turn too fast to follow, all corners are new. Keyframes there are compared
with keyframes of the map by descriptors of their corners, posed from the points they recognise,
and their corners become views of those points.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from gazemap.geometry.arrays import IntArray
from gazemap.slam.config import SlamConfig
from gazemap.slam.front import Skeleton
from gazemap.slam.structure import Structure, robust_pose
from gazemap.slam.video import GreyVideo

_TRIES_A_GAP = 4
_NEIGHBOURS = 4
_SPREAD = 12
_DESCRIPTOR_PX = 12.0
_RATIO = 0.8
_INLIER_PX = 4.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Looks:
    """Views (N,) of one keyframe and their descriptors (N, D)."""

    rows: IntArray
    descriptors: NDArray[np.float32]


def join(skeleton: Skeleton, video: GreyVideo, *, config: SlamConfig) -> bool:
    """Pose some keyframes that corners do not reach; return whether any was."""
    structure = skeleton.structure
    stranded = _stranded(structure)
    if not stranded or not structure.is_posed.any():
        return False
    base = _base(structure, stranded)
    looks = _describe(skeleton, video, keyframes=sorted({*stranded, *base}))
    joined = False
    for k in stranded:
        rows, points = _recognised(structure, looks[k], [looks[b] for b in base])
        if _pose(structure, k, rows=rows, points=points, min_inliers=config.min_inliers):
            off = structure.residual_px_to(rows, points)
            _merge(skeleton, rows[off < _INLIER_PX], points[off < _INLIER_PX])
            joined = True
    return joined


def _stranded(structure: Structure) -> list[int]:
    """Return some keyframes, well spread, of each run of keyframes without a pose."""
    unposed = np.flatnonzero(~structure.is_posed)
    runs = np.split(unposed, np.flatnonzero(np.diff(unposed) > 1) + 1)
    tries: set[int] = set()
    for run in runs:
        if len(run):
            tries |= {int(run[i]) for i in np.linspace(0, len(run) - 1, _TRIES_A_GAP).astype(int)}
    return sorted(tries)


def _base(structure: Structure, stranded: list[int]) -> list[int]:
    """Return keyframes of the map: those next to the gaps, and some from everywhere."""
    posed = np.flatnonzero(structure.is_posed)
    base = {int(posed[i]) for i in np.linspace(0, len(posed) - 1, _SPREAD).astype(int)}
    for k in stranded:
        nearest = np.argsort(np.abs(posed - k), kind="stable")[:_NEIGHBOURS]
        base |= {int(i) for i in posed[nearest]}
    return sorted(base)


def _describe(skeleton: Skeleton, video: GreyVideo, *, keyframes: list[int]) -> dict[int, _Looks]:
    """Return what the corners of keyframes look like, upright and at one size."""
    sift = cv2.SIFT.create()
    keyframe_at = {int(skeleton.frames[k]): k for k in keyframes}
    looks = {}
    for index, grey in video:
        if index not in keyframe_at:
            continue
        k = keyframe_at[index]
        views = skeleton.structure.views(k)
        corners = [
            cv2.KeyPoint(float(u), float(v), _DESCRIPTOR_PX, 0.0) for u, v in skeleton.uv_px[views]
        ]
        descriptors = sift.compute(grey, corners)[1]
        looks[k] = _Looks(
            rows=np.arange(views.start, views.stop),
            descriptors=np.asarray(descriptors, dtype=np.float32).reshape(len(corners), -1),
        )
    return looks


def _recognised(
    structure: Structure, looks: _Looks, base: list[_Looks]
) -> tuple[IntArray, IntArray]:
    """Return views (N,) of a keyframe and the tracks with points (N,) that they look like."""
    best: dict[int, tuple[float, int]] = {}
    for other in base:
        known = structure.has_point[structure.track[other.rows]] & structure.is_valid[other.rows]
        tracks = structure.track[other.rows[known]]
        for i, j, distance in _mutual(looks.descriptors, other.descriptors[known]):
            if distance < best.get(i, (np.inf, -1))[0]:
                best[i] = (distance, int(tracks[j]))
    views = np.array(sorted(best), dtype=np.int64)
    points = np.array([best[int(i)][1] for i in views], dtype=np.int64)
    # A point is recognised once: by the view that looks most like it.
    closeness = np.argsort([best[int(i)][0] for i in views], kind="stable")
    first = closeness[np.unique(points[closeness], return_index=True)[1]]
    return looks.rows[views[first]], points[first]


def _mutual(a: NDArray[np.float32], b: NDArray[np.float32]) -> list[tuple[int, int, float]]:
    """Return pairs that are each other's nearest and clearly nearer than the second."""
    if len(a) < 2 or len(b) < 2:
        return []
    matcher = cv2.BFMatcher(cv2.NORM_L2)
    back = {m.queryIdx: m.trainIdx for m in matcher.match(b, a)}
    return [
        (first.queryIdx, first.trainIdx, float(first.distance))
        for first, second in matcher.knnMatch(a, b, k=2)
        if first.distance < _RATIO * second.distance and back[first.trainIdx] == first.queryIdx
    ]


def _pose(
    structure: Structure, k: int, *, rows: IntArray, points: IntArray, min_inliers: int
) -> bool:
    if structure.is_posed[k] or len(rows) < min_inliers:
        return False
    near = structure.nearest_posed(k)
    fit = robust_pose(
        structure.R_cam_map[near],
        structure.t_cam_map[near],
        points_map=structure.points_map[points],
        flat=structure.flat[rows],
        focal_px=structure.focal_px,
    )
    if fit.inliers(_INLIER_PX / structure.focal_px).sum() < min_inliers:
        return False
    structure.set_pose(k, fit.R_cam_map, fit.t_cam_map)
    return True


def _merge(skeleton: Skeleton, rows: IntArray, points: IntArray) -> None:
    """Make the tracks of views (N,) the same as the tracks with points (N,)."""
    renamed = np.arange(len(skeleton.structure.has_point))
    renamed[skeleton.structure.track[rows]] = points
    skeleton.structure.track[:] = renamed[skeleton.structure.track]
    kept = skeleton.track_of >= 0
    skeleton.track_of[kept] = renamed[skeleton.track_of[kept]]
