"""Directions of gaze: pixels, angles in the camera, rays in world."""

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from gazemap.geometry.arrays import BoolArray, FloatArray, IntArray
from gazemap.types.tracking import Trajectory

_MAX_GAP_NS = 150_000_000


def angles_of(directions_cam: FloatArray) -> FloatArray:
    """Return azimuth (right positive) and elevation (up positive) (N, 2) of directions (N, 3)."""
    x, y, z = directions_cam.T
    return np.column_stack([np.arctan2(x, z), -np.arctan2(y, np.hypot(x, z))])


def directions_of(angles_rad: FloatArray) -> FloatArray:
    """Return unit directions (N, 3) in the camera frame of azimuth and elevation (N, 2)."""
    azimuth, elevation = angles_rad.T
    level = np.cos(elevation)
    return np.column_stack([level * np.sin(azimuth), -np.sin(elevation), level * np.cos(azimuth)])


def poses_at(trajectory: Trajectory, t_ns: IntArray) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return rotations (N, 3, 3) and centres (N, 3) of the camera, and which are known (N,).

    The pose is interpolated; it is unknown outside the path and in gaps over 0.15 s.
    """
    if len(trajectory) < 2:
        count = len(t_ns)
        return np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 3)), np.zeros(count, bool)
    after = np.clip(np.searchsorted(trajectory.t_ns, t_ns), 1, len(trajectory) - 1)
    gap = trajectory.t_ns[after] - trajectory.t_ns[after - 1]
    inside = (t_ns >= trajectory.t_ns[0]) & (t_ns <= trajectory.t_ns[-1])
    t_s = (trajectory.t_ns - trajectory.t_ns[0]) * 1e-9
    wanted_s = np.clip((t_ns - trajectory.t_ns[0]) * 1e-9, 0, t_s[-1])
    R = Slerp(t_s, Rotation.from_quat(trajectory.quat_xyzw.copy()))(wanted_s).as_matrix()
    p = np.column_stack([np.interp(wanted_s, t_s, trajectory.p_world_cam[:, k]) for k in range(3)])
    return R, p, np.asarray(inside & (gap <= _MAX_GAP_NS))
