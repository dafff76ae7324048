"""The motion prior: constant velocity on SE(3), turned by a gyroscope where there is one."""

import numpy as np
from scipy.spatial.transform import Rotation

from gazemap.geometry.align import Similarity
from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.live.gyro import Gyroscope

# Older motion says nothing about the present one.
_STALE_S = 0.25


class Motion:
    """The latest pose and how it moves."""

    def __init__(self, T_cam_world: Pose[Cam, World], t_ns: int, gyroscope: Gyroscope) -> None:
        """Start at rest; the gyroscope may have nothing to say."""
        self.T_cam_world, self.t_ns = T_cam_world, t_ns
        self._gyroscope = gyroscope
        self.twist: FloatArray = np.zeros(6)

    def predict(self, t_ns: int) -> Pose[Cam, World]:
        """Return the pose expected at a time."""
        dt_s = (t_ns - self.t_ns) * 1e-9
        turn_rate = self._gyroscope.turn_rate(self.t_ns, t_ns)
        if dt_s > _STALE_S and turn_rate is None:
            return self.T_cam_world
        slide = self.twist[3:] * dt_s if dt_s <= _STALE_S else np.zeros(3)
        rotvec = (self.twist[:3] if turn_rate is None else turn_rate) * dt_s
        turn = Rotation.from_rotvec(rotvec).as_matrix()
        return Pose(R=turn @ self.T_cam_world.R, t=turn @ self.T_cam_world.t + slide)

    def observe(self, T_cam_world: Pose[Cam, World], t_ns: int) -> None:
        """Take a new pose."""
        dt_s = (t_ns - self.t_ns) * 1e-9
        self.twist = twist_between(self.T_cam_world, T_cam_world, dt_s)
        if 0 < dt_s <= _STALE_S:
            self._gyroscope.learn(self.t_ns, t_ns, self.twist[:3])
        self.T_cam_world, self.t_ns = T_cam_world, t_ns

    def rest(self) -> None:
        """Forget the velocity."""
        self.twist = np.zeros(6)

    def transform(self, S_new_old: Similarity[World, World]) -> None:
        """Follow the map into its new world."""
        self.T_cam_world = S_new_old.transform_pose(self.T_cam_world.inverse()).inverse()
        self.twist = self.twist * np.array([1, 1, 1, *[S_new_old.scale] * 3])


def twist_between(before: Pose[Cam, World], after: Pose[Cam, World], dt_s: float) -> FloatArray:
    """Return the twist (6,) of `T_cam_world` from the left, a second; at rest after a gap."""
    if not 0 < dt_s <= _STALE_S:
        return np.zeros(6)
    turn = after.R @ before.R.T
    rotvec = Rotation.from_matrix(turn).as_rotvec()
    return np.concatenate([rotvec, after.t - turn @ before.t]) / dt_s
