"""The poses of all frames in the map, and how the camera moved meanwhile."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from gazemap.geometry.arrays import BoolArray, FloatArray, IntArray


@dataclass(slots=True, kw_only=True, eq=False)
class FramePath:
    """One pose a frame; rows of frames that are not posed mean nothing.

    Attributes:
        t_ns: (N,) times.
        R_cam_map: (N, 3, 3).
        t_cam_map: (N, 3).
        is_posed: (N,).
        information: (N, 6, 6) of the left tangent, 1 / flat^2.
        inlier_count: (N,) points that agree with the pose.
    """

    t_ns: IntArray
    R_cam_map: FloatArray
    t_cam_map: FloatArray
    is_posed: BoolArray
    information: FloatArray
    inlier_count: IntArray

    @staticmethod
    def unposed(t_ns: IntArray) -> "FramePath":
        """Return the path of which nothing is known."""
        count = len(t_ns)
        return FramePath(
            t_ns=t_ns,
            R_cam_map=np.tile(np.eye(3), (count, 1, 1)),
            t_cam_map=np.zeros((count, 3)),
            is_posed=np.zeros(count, dtype=np.bool_),
            information=np.zeros((count, 6, 6)),
            inlier_count=np.zeros(count, dtype=np.int64),
        )

    def follow(self, frames: IntArray, R_cam_map: FloatArray, t_cam_map: FloatArray) -> None:
        """Set the poses of some frames (K,), and move each other frame with the nearest of them."""
        is_set = np.zeros(len(self.t_ns), dtype=np.bool_)
        is_set[frames] = True
        others = np.flatnonzero(self.is_posed & ~is_set)
        near = _nearest(frames, others)
        R_old, t_old = self.R_cam_map[frames[near]], self.t_cam_map[frames[near]]
        R = self.R_cam_map[others] @ R_old.transpose(0, 2, 1)
        step = self.t_cam_map[others] - np.einsum("nij,nj->ni", R, t_old)
        self.R_cam_map[others] = R @ R_cam_map[near]
        self.t_cam_map[others] = np.einsum("nij,nj->ni", R, t_cam_map[near]) + step
        self.R_cam_map[frames], self.t_cam_map[frames] = R_cam_map, t_cam_map
        self.is_posed[frames] = True

    def twists(self) -> FloatArray:
        """Return how each frame's pose changes per second (N, 6), as a left tangent.

        It is the mean between the frames before and after; zero where neither is posed.
        """
        count = len(self.t_ns)
        here = np.arange(count)
        before, after = np.maximum(here - 1, 0), np.minimum(here + 1, count - 1)
        before = np.where(self.is_posed[before], before, here)
        after = np.where(self.is_posed[after], after, here)
        span_s = np.maximum(self.t_ns[after] - self.t_ns[before], 1) / 1e9
        R = self.R_cam_map[after] @ self.R_cam_map[before].transpose(0, 2, 1)
        moved = self.t_cam_map[after] - np.einsum("nij,nj->ni", R, self.t_cam_map[before])
        turned = Rotation.from_matrix(R).as_rotvec()
        twists = np.concatenate([turned, moved], axis=1) / span_s[:, None]
        twists[(after == before) | ~self.is_posed] = 0.0
        return np.asarray(twists)


def _nearest(ascending: IntArray, numbers: IntArray) -> IntArray:
    """Return the index of the nearest of ascending numbers (K,) for each number (N,)."""
    after = np.clip(np.searchsorted(ascending, numbers), 1, max(len(ascending) - 1, 1))
    before_is_nearer = (
        numbers - ascending[after - 1] <= ascending[np.minimum(after, len(ascending) - 1)] - numbers
    )
    return np.where(before_is_nearer, after - 1, np.minimum(after, len(ascending) - 1))


def shutter_shift(in_cam: FloatArray, *, twist: FloatArray, delay_s: FloatArray) -> FloatArray:
    """Return how far the rolling shutter moved the views of points, in flat units (N, 2).

    Args:
        in_cam: (N, 3) points in the camera at the frame's time.
        twist: (6,) or (N, 6) motion of the camera, a left tangent per second.
        delay_s: (N,) when each view's row was exposed after the frame's time.
    """
    turn, slide = twist[..., :3], twist[..., 3:]
    later = in_cam + delay_s[:, None] * (np.cross(turn, in_cam) + slide)
    shift: FloatArray = later[:, :2] / later[:, 2:] - in_cam[:, :2] / in_cam[:, 2:]
    return shift
