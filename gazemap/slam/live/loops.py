"""Loops: the camera comes back to a part of the map that its drift has moved away from."""

import itertools

import numpy as np

from gazemap.geometry.align import Similarity
from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.live.adjustment import covisible_window
from gazemap.slam.live.landmarks import Landmarks
from gazemap.slam.live.mapdata import Keyframe, SparseMap
from gazemap.slam.live.meeting import Recognitions
from gazemap.slam.live.pose_graph import LoopEdge, close_loops
from gazemap.types.tracking import Scale

_RECENT_KEYFRAMES = 15
_LEAST_OLD_POINTS = 80
# Points within this reach are found without closing anything.
_LEAST_DRIFT_PX = 6.0
_NEIGHBOURS = 6


class LoopFinder:
    """Looks for the latest keyframe among the points that its surroundings do not see."""

    def __init__(self, camera: Camera) -> None:
        """Start without any."""
        self._camera = camera
        self._recognitions = Recognitions(camera)

    def find(self, sparse: SparseMap, keyframe: Keyframe) -> Similarity[World, World] | None:
        """Return by what the surroundings of the keyframe must move, once that is sure."""
        old = _old_landmarks(sparse, keyframe.keyframe_id)
        if len(old) < _LEAST_OLD_POINTS:
            return None
        place = self._recognitions.recognise(old, keyframe)
        if place is None:
            return None
        rows, _ = old.rows_of(place.ids)
        points = old.points_world[rows]
        expected_px = self._camera.project(keyframe.T_cam_world.transform(points))
        drift_px = np.linalg.norm(np.nan_to_num(expected_px, nan=1e4) - place.uv_px, axis=1)
        if float(np.median(drift_px)) < _LEAST_DRIFT_PX:
            self._recognitions.forget()
            return None
        away = np.linalg.norm(points - place.T_cam_world.inverse().t, axis=1)
        S = self._recognitions.agreed(sparse, depth=float(np.median(away)))
        if S is not None:
            self._recognitions.forget()
        return S


def close_loop(
    sparse: SparseMap, keyframe: Keyframe, S_old_present: Similarity[World, World]
) -> Similarity[World, World]:
    """Bend the map so that the keyframe comes to its place; return how its surroundings moved."""
    T_world_cam = {k: f.T_cam_world.inverse() for k, f in sparse.keyframes.items()}
    here = _nearest_old(sparse, keyframe, S_old_present)
    depth = float(np.median(_depths(sparse, keyframe)))
    T_old_there = S_old_present.transform_pose(T_world_cam[keyframe.keyframe_id])
    relative = T_world_cam[here].inverse() @ T_old_there
    loop = LoopEdge(
        here=here,
        there=keyframe.keyframe_id,
        S_here_there=Similarity(scale=S_old_present.scale, R=relative.R, t=relative.t),
    )
    solved = close_loops(
        T_world_cam,
        _edges(sparse),
        [loop],
        depth=depth,
        metric=sparse.scale is Scale.METRIC,
    )
    return _move(sparse, solved, keyframe.keyframe_id)


def _move(
    sparse: SparseMap, solved: dict[int, Similarity[World, Cam]], keyframe_id: int
) -> Similarity[World, World]:
    """Move every keyframe with the points that it saw first."""
    f = sparse.features
    moved: Similarity[World, World] = Similarity.identity()
    for k, S_world_cam in solved.items():
        frame = sparse.keyframes[k]
        T_cam_world = frame.T_cam_world
        hosted = f.host == k
        f.points_world[hosted] = S_world_cam.transform(
            T_cam_world.transform(f.points_world[hosted])
        )
        if k == keyframe_id:
            moved = _composed(S_world_cam, T_cam_world)
        T_world_cam: Pose[World, Cam] = Pose(R=S_world_cam.R, t=S_world_cam.t)
        frame.T_cam_world = T_world_cam.inverse()
        frame.T_cam_world_published = frame.T_cam_world
        frame.twist = frame.twist * np.array([1, 1, 1, *[S_world_cam.scale] * 3])
    return moved


def _composed(
    S_world_cam: Similarity[World, Cam], T_cam_world: Pose[Cam, World]
) -> Similarity[World, World]:
    R = S_world_cam.R @ T_cam_world.R
    return Similarity(scale=S_world_cam.scale, R=R, t=S_world_cam.transform(T_cam_world.t))


def _old_landmarks(sparse: SparseMap, keyframe_id: int) -> Landmarks:
    """Return the points that neither the latest keyframes nor those around have measured."""
    m = sparse.measurements
    ids = np.array(sorted(sparse.keyframes))
    around = covisible_window(sparse, keyframe_id, count=len(ids))
    near = np.union1d(around, ids[-_RECENT_KEYFRAMES:])
    every = sparse.landmarks()
    return every.chosen(~np.isin(every.ids, m.feature[np.isin(m.keyframe, near)]))


def _nearest_old(
    sparse: SparseMap, keyframe: Keyframe, S_old_present: Similarity[World, World]
) -> int:
    """Return the keyframe, not one of the latest, that is nearest to where the camera is."""
    ids = np.array(sorted(sparse.keyframes))[:-_RECENT_KEYFRAMES]
    centre = S_old_present.transform_pose(keyframe.T_cam_world.inverse()).t
    centres = np.array([sparse.keyframes[int(k)].T_cam_world.inverse().t for k in ids])
    return int(ids[np.linalg.norm(centres - centre, axis=1).argmin()])


def _depths(sparse: SparseMap, keyframe: Keyframe) -> FloatArray:
    m, f = sparse.measurements, sparse.features
    ids = m.feature[m.keyframe == keyframe.keyframe_id]
    points = f.points_world[f.rows_of(ids)]
    return np.asarray(keyframe.T_cam_world.transform(points[~np.isnan(points[:, 0])])[:, 2])


def _edges(sparse: SparseMap) -> list[tuple[int, int]]:
    """Return neighbours in time and those that share most points."""
    ids = sorted(sparse.keyframes)
    edges = set(itertools.pairwise(ids))
    for k in ids:
        for other in covisible_window(sparse, k, count=_NEIGHBOURS)[1:]:
            edges.add((min(k, int(other)), max(k, int(other))))
    return sorted(edges)
