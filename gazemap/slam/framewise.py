"""Poses of all frames from the points each of them sees."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gazemap.geometry.arrays import FloatArray, IntArray
from gazemap.slam.config import SlamConfig
from gazemap.slam.frame_path import FramePath
from gazemap.slam.front import FollowedCorners, Skeleton
from gazemap.slam.pose_solver import PoseFit, fit_pose
from gazemap.slam.structure import robust_pose

_INLIER_PX = 3.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FrameViews:
    """The points that one frame sees: (N,) indices and their views (N, 2) as x/z, y/z."""

    point: IntArray
    flat: FloatArray


def pose_frames_by_corners(
    followed: FollowedCorners, skeleton: Skeleton, *, t_ns: IntArray, config: SlamConfig
) -> FramePath:
    """Return the path of all frames that see enough points of the corners' map."""
    structure = skeleton.structure
    path = FramePath.unposed(t_ns)
    posed = np.flatnonzero(structure.is_posed)
    if len(posed) == 0:
        return path
    start = (structure.R_cam_map[posed[0]], structure.t_cam_map[posed[0]])
    keyframe_of = {int(f): k for k, f in enumerate(skeleton.frames) if structure.is_posed[k]}
    for i, corners in enumerate(followed.corners):
        if i in keyframe_of:
            start = (structure.R_cam_map[keyframe_of[i]], structure.t_cam_map[keyframe_of[i]])
        track = skeleton.track_of[corners.track_id]
        known = track >= 0
        known[known] = structure.has_point[track[known]]
        if known.sum() < config.min_inliers:
            continue
        fit = robust_pose(
            *start,
            points_map=structure.points_map[track[known]],
            flat=followed.flat[i][known],
            focal_px=structure.focal_px,
        )
        if _accept(path, i, fit=fit, focal_px=structure.focal_px, config=config):
            start = (fit.R_cam_map, fit.t_cam_map)
    return path


def pose_frames(
    path: FramePath,
    views: Sequence[FrameViews],
    *,
    points_map: FloatArray,
    focal_px: float,
    config: SlamConfig,
) -> None:
    """Improve the poses of all frames that have one from their views of fixed points (P, 3)."""
    for i in np.flatnonzero(path.is_posed).tolist():
        fit = fit_pose(
            path.R_cam_map[i],
            path.t_cam_map[i],
            points_map=points_map[views[i].point],
            flat=views[i].flat,
            cauchy=config.final_cauchy_px / focal_px,
        )
        _accept(path, i, fit=fit, focal_px=focal_px, config=config)


def _accept(path: FramePath, i: int, *, fit: PoseFit, focal_px: float, config: SlamConfig) -> bool:
    inliers = fit.inliers(_INLIER_PX / focal_px)
    good = int(inliers.sum()) >= max(config.min_inliers, 0.3 * len(inliers))
    path.is_posed[i] = good
    if good:
        path.R_cam_map[i], path.t_cam_map[i] = fit.R_cam_map, fit.t_cam_map
        path.information[i] = fit.information
        path.inlier_count[i] = inliers.sum()
    return good
