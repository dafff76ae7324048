"""The first two views of a map: chosen, solved as a plane and as a space, and tried on others."""

from dataclasses import dataclass

import cv2
import numpy as np

from gazemap.errors import SolverError
from gazemap.geometry.arrays import FloatArray, IntArray
from gazemap.slam.config import SlamConfig
from gazemap.slam.structure import Structure, intersect_rays

_FEWEST_COMMON = 40
_RANSAC_PX = 1.0
_WIDE_ENOUGH_RAD = np.radians(8.0)
_TOO_NARROW_RAD = np.radians(1.0)
_STARTS = 10


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Pair:
    """Two keyframes, and `T_second_first` with a baseline of length one, as (R, t) hypotheses."""

    first: int
    second: int
    score: float
    motions: list[tuple[FloatArray, FloatArray]]


def bootstrap(structure: Structure, config: SlamConfig) -> bool:
    """Pose the keyframes of the best pair and those between; return False without parallax."""
    solved = [_solve(structure, a, b) for a, b in _candidates(structure)]
    pairs = [pair for pair in solved if pair is not None]
    for pair in sorted(pairs, key=lambda p: -p.score)[:3]:
        best = max(pair.motions, key=lambda motion: _try(structure, pair, motion, config=config))
        if _try(structure, pair, best, config=config) >= _FEWEST_COMMON:
            return True
    _clear(structure)
    return False


def _candidates(structure: Structure) -> list[tuple[int, int]]:
    """Return pairs of keyframes that share from 80 down to 35 % of the first one's tracks."""
    count = len(structure.is_posed)
    pairs = []
    for a in sorted({int(x) for x in np.linspace(0, max(count - 2, 0), _STARTS)}):
        mine = structure.track[structure.views(a)]
        for share in (0.8, 0.6, 0.35):
            b = a
            while b + 1 < count and _shared(structure, mine, b + 1) >= share * len(mine):
                b += 1
            if b > a:
                pairs.append((a, b))
    return sorted(set(pairs))


def _shared(structure: Structure, tracks: IntArray, k: int) -> int:
    return int(np.isin(structure.track[structure.views(k)], tracks, assume_unique=True).sum())


def _common(structure: Structure, a: int, b: int) -> tuple[FloatArray, FloatArray]:
    rows_a, rows_b = structure.views(a), structure.views(b)
    _, i, j = np.intersect1d(
        structure.track[rows_a], structure.track[rows_b], assume_unique=True, return_indices=True
    )
    return structure.flat[rows_a][i], structure.flat[rows_b][j]


def _solve(structure: Structure, a: int, b: int) -> _Pair | None:
    flat_a, flat_b = _common(structure, a, b)
    if len(flat_a) < _FEWEST_COMMON:
        return None
    radius = _RANSAC_PX / structure.focal_px
    essential, mask = cv2.findEssentialMat(
        flat_a, flat_b, np.eye(3), method=cv2.RANSAC, prob=0.999, threshold=radius
    )
    inside = np.asarray(mask).ravel() > 0
    if np.shape(essential) != (3, 3) or not inside.any():
        return None
    _, turn, origin, _ = cv2.recoverPose(essential, flat_a, flat_b, np.eye(3), mask=mask.copy())
    R, t = np.asarray(turn, dtype=np.float64), np.asarray(origin, dtype=np.float64).ravel()
    parallax = _parallax(R, t, flat_a[inside], flat_b[inside])
    if parallax < _TOO_NARROW_RAD:
        return None
    motions = [(R, t), *_plane_motions(flat_a, flat_b, radius=radius)]
    score = float(inside.sum()) * min(parallax, _WIDE_ENOUGH_RAD)
    return _Pair(first=a, second=b, score=score, motions=motions)


def _plane_motions(
    flat_a: FloatArray, flat_b: FloatArray, *, radius: float
) -> list[tuple[FloatArray, FloatArray]]:
    H, mask = cv2.findHomography(flat_a, flat_b, cv2.RANSAC, 2 * radius)
    if np.shape(H) != (3, 3) or np.asarray(mask).sum() < 0.5 * len(flat_a):
        return []
    _, rotations, origins, _ = cv2.decomposeHomographyMat(H, np.eye(3))
    motions = []
    for R, origin in zip(rotations, origins, strict=True):
        t = np.asarray(origin, dtype=np.float64).ravel()
        length = float(np.linalg.norm(t))
        if length > 1e-6:
            motions.append((np.asarray(R, dtype=np.float64), t / length))
    return motions


def _parallax(R: FloatArray, t: FloatArray, flat_a: FloatArray, flat_b: FloatArray) -> float:
    """Return the median angle between the rays, in radians, over points in front of both."""
    count = len(flat_a)
    rotations = np.concatenate([np.tile(np.eye(3), (count, 1, 1)), np.tile(R, (count, 1, 1))])
    origins = np.concatenate([np.zeros((count, 3)), np.tile(t, (count, 1))])
    group = np.tile(np.arange(count), 2)
    points, angle = intersect_rays(
        rotations, origins, np.concatenate([flat_a, flat_b]), group=group, group_count=count
    )
    front = (points[:, 2] > 0) & ((points @ R.T + t)[:, 2] > 0)
    return float(np.median(angle[front])) if front.sum() >= 0.5 * count else 0.0


def _try(
    structure: Structure, pair: _Pair, motion: tuple[FloatArray, FloatArray], *, config: SlamConfig
) -> int:
    """Build the map of a motion with some keyframes between; return how many views fit well."""
    _clear(structure)
    structure.set_pose(pair.first, np.eye(3), np.zeros(3))
    structure.set_pose(pair.second, *motion)
    structure.triangulate(min_parallax_rad=0.5 * _TOO_NARROW_RAD)
    if structure.has_point.sum() < config.min_inliers:
        return 0
    between = np.linspace(pair.first, pair.second, 5).astype(int)[1:-1]
    for k in sorted(set(between.tolist()) - {pair.first, pair.second}):
        structure.locate(k, min_inliers=config.min_inliers)
    try:
        structure.adjust(cauchy_px=config.bundle_cauchy_px)
    except SolverError:
        return 0
    return int((structure.residual_px() < _RANSAC_PX).sum())


def _clear(structure: Structure) -> None:
    structure.is_posed[:] = False
    structure.has_point[:] = False
    structure.is_valid[:] = True
