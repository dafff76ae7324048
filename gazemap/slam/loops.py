"""Loops offline: keyframes that see an old part of the map, which drift has moved away from.

Corners are new each time they come into view, so nothing ties a place to what was seen of it
before. Keyframes are looked for among the old points by binary descriptors and posed in them; what
several of them agree on bends the map as a graph of similarities (the scale drifts too), and the
corners that were recognised become views of the old points.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from gazemap.errors import SolverError
from gazemap.geometry.align import Similarity
from gazemap.geometry.arrays import FloatArray, ImageArray, IntArray
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.front import Skeleton
from gazemap.slam.live.patches import Pyramid, cut_patches
from gazemap.slam.live.places import describe
from gazemap.slam.live.pose_graph import LoopEdge, close_loops
from gazemap.slam.pose_solver import fit_pose
from gazemap.slam.structure import Structure
from gazemap.slam.video import GreyVideo

_RECENT_KEYFRAMES = 12
_QUERY_EVERY = 2
_FEWEST_OLD_POINTS = 80
_LARGEST_INDEX = 4000
_WORST_DISTANCE = 64
_RANSAC_PX = 4.0
_FEWEST_SAMPLED = 12
_NEAR_PX = 8.0
_NEAR_POINTS = 16
_WORST_NEAR_DISTANCE = 70
_INLIER_PX = 3.0
_FEWEST_INLIERS = 30
_LEAST_SHARE = 0.25
# Closer than this the patches find their points without closing anything.
_LEAST_DRIFT_PX = 4.0
_AGREEING_PX = 10.0
_AGREEING_KEYFRAMES = 8
_NEIGHBOURS = 5
_LOOSE_CAUCHY_PX = 2.0
_ITERATIONS = 20


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Loop:
    """A keyframe that was recognised among old points.

    Attributes:
        keyframe: which one.
        old_keyframe: the one that saw most of the old points.
        S_old_present: what puts the keyframe's surroundings to their place in the old part.
        rows: (N,) its views that were recognised.
        tracks: (N,) the tracks of the old points.
        drift_px: how far the old points are from where the keyframe sees them, in the median.
    """

    keyframe: int
    old_keyframe: int
    S_old_present: Similarity[World, World]
    rows: IntArray
    tracks: IntArray
    drift_px: float


def close_all_loops(skeleton: Skeleton, video: GreyVideo) -> bool:
    """Bend the map so that it meets where it shows the same place; return whether it had to be."""
    structure = skeleton.structure
    posed = np.flatnonzero(structure.is_posed)
    if len(posed) <= _RECENT_KEYFRAMES:
        return False
    index = _Index(structure, _described(skeleton, video))
    found = [index.recognise(int(k)) for k in posed[::_QUERY_EVERY]]
    loops = agreeing(structure, [loop for loop in found if loop is not None])
    if max((loop.drift_px for loop in loops), default=0.0) < _LEAST_DRIFT_PX:
        return False
    bend(structure, loops)
    merge_tracks(skeleton, loops)
    try:
        structure.adjust(cauchy_px=_LOOSE_CAUCHY_PX, iterations=_ITERATIONS)
    except SolverError:
        structure.judge(worst_px=_RANSAC_PX)
    return True


def _described(skeleton: Skeleton, video: GreyVideo) -> ImageArray:
    """Return descriptors (M, 2, 32) of all views of posed keyframes, at both resolutions."""
    structure = skeleton.structure
    keyframe_at = {int(f): k for k, f in enumerate(skeleton.frames) if structure.is_posed[k]}
    descriptors = np.zeros((len(structure.track), 2, 32), dtype=np.uint8)
    for index, grey in video:
        if index in keyframe_at:
            rows = structure.views(keyframe_at[index])
            at_px = 2.0 * np.rint(skeleton.uv_px[rows] / 2.0)
            descriptors[rows] = describe(cut_patches(Pyramid.of(grey), at_px))
    return descriptors


class _Index:
    """The points' descriptors, each from the first keyframe that saw it."""

    def __init__(self, structure: Structure, descriptors: ImageArray) -> None:
        """Take the descriptors (M, 2, 32) of all views."""
        self._structure, self._descriptors = structure, descriptors
        rows = np.flatnonzero(
            structure.has_point[structure.track] & structure.is_posed[structure.keyframe]
            & structure.is_valid
        )  # fmt: skip
        self._tracks, first, counts = np.unique(
            structure.track[rows], return_index=True, return_counts=True
        )
        self._first, self._length = rows[first], counts
        last = np.zeros(len(structure.has_point), dtype=np.int64)
        np.maximum.at(last, structure.track[rows], structure.keyframe[rows])
        self._last_keyframe = last[self._tracks]

    def recognise(self, k: int) -> Loop | None:
        """Look for keyframe k among the points that were lost sight of long before it."""
        structure = self._structure
        old = np.flatnonzero(self._last_keyframe < k - _RECENT_KEYFRAMES)
        if len(old) < _FEWEST_OLD_POINTS:
            return None
        here: Pose[Cam, World] = Pose(R=structure.R_cam_map[k], t=structure.t_cam_map[k])
        loop = self._settled(k, old, here)
        if loop is not None:
            return loop
        start = self._sampled(*self._matches(k, old))
        return self._settled(k, old, start) if start is not None else None

    def _sampled(self, rows: IntArray, tracks: IntArray) -> Pose[Cam, World] | None:
        """Return the pose that most of the views (N,) of tracks agree on."""
        structure = self._structure
        if len(rows) < _FEWEST_SAMPLED:
            return None
        points, flat = structure.points_map[tracks], structure.flat[rows]
        solved = cv2.solvePnPRansac(
            points, flat, np.eye(3), None, iterationsCount=1000,
            reprojectionError=_RANSAC_PX / structure.focal_px, confidence=0.999,
            flags=cv2.SOLVEPNP_AP3P,
        )  # fmt: skip
        inlier = np.ravel(solved[3] if solved[0] else []).astype(np.int64)
        if len(inlier) < _FEWEST_SAMPLED:
            return None
        start: Pose[Cam, World] = Pose.from_rotvec(np.ravel(solved[1]), np.ravel(solved[2]))
        return self._posed(start, rows[inlier], tracks[inlier])

    def _settled(self, k: int, old: IntArray, start: Pose[Cam, World]) -> Loop | None:
        """Return the loop to the old points that look like views where a pose puts them."""
        structure, T_cam_old = self._structure, start
        rows = tracks = np.empty(0, dtype=np.int64)
        for _ in range(2):
            rows, tracks = self._near(k, old, T_cam_old)
            if len(rows) < _FEWEST_INLIERS:
                return None
            T_cam_old = self._posed(T_cam_old, rows, tracks)
        in_cam = T_cam_old.transform(structure.points_map[tracks])
        off = np.linalg.norm(in_cam[:, :2] / in_cam[:, 2:] - structure.flat[rows], axis=1)
        good = off < _INLIER_PX / structure.focal_px
        if good.sum() < max(_FEWEST_INLIERS, _LEAST_SHARE * len(good)):
            return None
        return self._loop(k, rows[good], tracks[good], T_cam_old)

    def _posed(self, start: Pose[Cam, World], rows: IntArray, tracks: IntArray) -> Pose[Cam, World]:
        structure = self._structure
        fit = fit_pose(
            start.R, start.t, points_map=structure.points_map[tracks], flat=structure.flat[rows],
            cauchy=1.0 / structure.focal_px,
        )  # fmt: skip
        return Pose(R=fit.R_cam_map, t=fit.t_cam_map)

    def _near(
        self, k: int, old: IntArray, T_cam_old: Pose[Cam, World]
    ) -> tuple[IntArray, IntArray]:
        """Return views (N,) of keyframe k and old tracks that look alike where a pose puts them."""
        structure, views = self._structure, self._structure.views(k)
        in_cam = T_cam_old.transform(structure.points_map[self._tracks[old]])
        old, in_cam = old[in_cam[:, 2] > 1e-6], in_cam[in_cam[:, 2] > 1e-6]
        tree = cKDTree(in_cam[:, :2] / in_cam[:, 2:])
        away, which = tree.query(
            structure.flat[views],
            k=_NEAR_POINTS,
            distance_upper_bound=_NEAR_PX / structure.focal_px,
        )
        mine, rank = np.nonzero(np.isfinite(away))
        theirs = old[np.asarray(which)[mine, rank]]
        differ = np.bitwise_xor(
            self._descriptors[views.start + mine], self._descriptors[self._first[theirs]]
        )
        distance = np.bitwise_count(differ).sum(axis=2).min(axis=1)
        order = np.argsort(distance, kind="stable")
        order = order[distance[order] < _WORST_NEAR_DISTANCE]
        # Each is taken by the one that looks most like it.
        order = order[np.sort(np.unique(mine[order], return_index=True)[1])]
        order = order[np.sort(np.unique(theirs[order], return_index=True)[1])]
        return views.start + mine[order], self._tracks[theirs[order]]

    def _matches(self, k: int, old: IntArray) -> tuple[IntArray, IntArray]:
        """Return views (N,) of keyframe k and the old tracks whose looks choose each other."""
        structure = self._structure
        old = old[np.argsort(-self._length[old], kind="stable")[:_LARGEST_INDEX]]
        views = structure.views(k)
        query = self._descriptors[views].reshape(-1, 32)
        train = self._descriptors[self._first[old]].reshape(-1, 32)
        found = cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True).match(query, train)
        near = [m for m in found if m.distance < _WORST_DISTANCE]
        rows = views.start + np.array([m.queryIdx // 2 for m in near], dtype=np.int64)
        tracks = self._tracks[old[np.array([m.trainIdx // 2 for m in near], dtype=np.int64)]]
        # Both resolutions of a view may have been matched.
        _, unique = np.unique(rows, return_index=True)
        return rows[unique], tracks[unique]

    def _loop(
        self, k: int, rows: IntArray, tracks: IntArray, T_cam_old: Pose[Cam, World]
    ) -> Loop | None:
        structure = self._structure
        mine = structure.track[rows]
        both = structure.has_point[mine]
        if both.sum() < _FEWEST_INLIERS // 2:
            return None
        R, t = structure.R_cam_map[k], structure.t_cam_map[k]
        depth = structure.points_map[mine[both]] @ R[2] + t[2]
        old_depth = T_cam_old.transform(structure.points_map[tracks[both]])[:, 2]
        scale = float(np.median(old_depth / np.maximum(depth, 1e-9)))
        if not 0.2 < scale < 5.0:
            return None
        S_old_present: Similarity[World, World] = Similarity(
            scale=scale, R=T_cam_old.R.T @ R, t=T_cam_old.R.T @ (scale * t - T_cam_old.t)
        )
        sees = np.isin(structure.track, tracks) & structure.is_posed[structure.keyframe]
        sees &= structure.keyframe < k - _RECENT_KEYFRAMES
        return Loop(
            keyframe=k,
            old_keyframe=int(np.bincount(structure.keyframe[sees]).argmax()),
            S_old_present=S_old_present,
            rows=rows,
            tracks=tracks,
            drift_px=float(np.median(structure.residual_px_to(rows, tracks))),
        )


def agreeing(structure: Structure, found: Sequence[Loop]) -> list[Loop]:
    """Return the loops that another keyframe nearby confirms."""
    return [
        loop
        for loop in found
        if any(
            0 < abs(loop.keyframe - other.keyframe) <= _AGREEING_KEYFRAMES
            and _error_px(structure, loop, other.S_old_present) < _AGREEING_PX
            for other in found
        )
    ]


def _error_px(structure: Structure, loop: Loop, S: Similarity[World, World]) -> float:
    """Return how far a loop's keyframe, moved by a similarity, sees the old points from there."""
    R, t = structure.R_cam_map[loop.keyframe], structure.t_cam_map[loop.keyframe]
    in_cam = S.inverse().transform(structure.points_map[loop.tracks]) @ R.T + t
    with np.errstate(divide="ignore", invalid="ignore"):
        off = np.linalg.norm(in_cam[:, :2] / in_cam[:, 2:] - structure.flat[loop.rows], axis=1)
    off[in_cam[:, 2] < 1e-6] = np.inf
    return float(np.median(off) * structure.focal_px)


def bend(structure: Structure, loops: Sequence[Loop]) -> None:
    """Spread what the loops say over all keyframes, and take each point along with its first."""
    T_world_cam: dict[int, Pose[World, Cam]] = {}
    for k in np.flatnonzero(structure.is_posed).tolist():
        T_cam_world: Pose[Cam, World] = Pose(R=structure.R_cam_map[k], t=structure.t_cam_map[k])
        T_world_cam[k] = T_cam_world.inverse()
    edges = [_edge(loop, T_world_cam) for loop in loops]
    solved = close_loops(
        T_world_cam, _neighbours(structure), edges, depth=_depth(structure), metric=False
    )
    used = structure.has_point[structure.track] & structure.is_posed[structure.keyframe]
    rows = np.flatnonzero(used)
    tracks, first = np.unique(structure.track[rows], return_index=True)
    host = structure.keyframe[rows[first]]
    for k, S_world_cam in solved.items():
        mine = tracks[host == k]
        in_cam = structure.points_map[mine] @ structure.R_cam_map[k].T + structure.t_cam_map[k]
        structure.points_map[mine] = S_world_cam.transform(in_cam)
        T_new: Pose[World, Cam] = Pose(R=S_world_cam.R, t=S_world_cam.t)
        structure.set_pose(k, T_new.inverse().R, T_new.inverse().t)


def _edge(loop: Loop, T_world_cam: dict[int, Pose[World, Cam]]) -> LoopEdge:
    T_old_there = loop.S_old_present.transform_pose(T_world_cam[loop.keyframe])
    relative = T_world_cam[loop.old_keyframe].inverse() @ T_old_there
    return LoopEdge(
        here=loop.old_keyframe,
        there=loop.keyframe,
        S_here_there=Similarity(scale=loop.S_old_present.scale, R=relative.R, t=relative.t),
    )


def _neighbours(structure: Structure) -> list[tuple[int, int]]:
    """Return pairs of posed keyframes: those that follow one another or share most points."""
    posed = np.flatnonzero(structure.is_posed)
    used = structure.has_point[structure.track] & structure.is_posed[structure.keyframe]
    used &= structure.is_valid
    sees = csr_array(
        (np.ones(int(used.sum())), (structure.keyframe[used], structure.track[used])),
        shape=(len(structure.is_posed), len(structure.has_point)),
    )
    shared: FloatArray = (sees @ sees.T).toarray()
    np.fill_diagonal(shared, 0)
    pairs = set(zip(posed[:-1].tolist(), posed[1:].tolist(), strict=True))
    for k in posed.tolist():
        for other in np.argsort(-shared[k], kind="stable")[:_NEIGHBOURS].tolist():
            if shared[k, other] > 0:
                pairs.add((min(k, other), max(k, other)))
    return sorted(pairs)


def _depth(structure: Structure) -> float:
    used = structure.has_point[structure.track] & structure.is_posed[structure.keyframe]
    k, points = structure.keyframe[used], structure.points_map[structure.track[used]]
    depth = np.einsum("nj,nj->n", structure.R_cam_map[k, 2], points) + structure.t_cam_map[k, 2]
    return float(np.median(depth))


def merge_tracks(skeleton: Skeleton, loops: Sequence[Loop]) -> None:
    """Make views that were recognised views of the old points, where no keyframe sees both."""
    structure = skeleton.structure
    order = np.argsort(structure.track, kind="stable")
    start = np.searchsorted(structure.track[order], np.arange(len(structure.has_point) + 1))
    renamed = np.arange(len(structure.has_point))
    keyframes: dict[int, set[int]] = {}

    def seen_by(track: int) -> set[int]:
        if track not in keyframes:
            rows = order[start[track] : start[track + 1]]
            keyframes[track] = set(structure.keyframe[rows].tolist())
        return keyframes[track]

    for loop in loops:
        structure.is_valid[loop.rows] = True
        for new, old in zip(structure.track[loop.rows].tolist(), loop.tracks.tolist(), strict=True):
            a, b = _root(renamed, new), _root(renamed, old)
            if a != b and not (seen_by(a) & seen_by(b)):
                renamed[a] = b
                keyframes[b] = seen_by(a) | seen_by(b)
    roots = np.array([_root(renamed, track) for track in range(len(renamed))], dtype=np.int64)
    structure.has_point[roots != np.arange(len(roots))] = False
    structure.track[:] = roots[structure.track]
    kept = skeleton.track_of >= 0
    skeleton.track_of[kept] = roots[skeleton.track_of[kept]]


def _root(renamed: IntArray, track: int) -> int:
    while renamed[track] != track:
        track = int(renamed[track])
    return track
