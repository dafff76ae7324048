"""Where the head camera was: outcomes frame by frame, and the whole path."""

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from gazemap.errors import ConventionError
from gazemap.geometry.arrays import FloatArray, IntArray, frozen_floats, frozen_ints
from gazemap.geometry.pose import Cam, GazeCam, Pose, World


class Scale(StrEnum):
    """Whether lengths are metres."""

    METRIC = "metric"
    ARBITRARY = "arbitrary"


class LostReason(StrEnum):
    """Why a frame has no pose."""

    STARTING = "starting"
    BLANK = "blank"
    BLURRED = "blurred"
    FEW_FEATURES = "few features"
    FEW_INLIERS = "few inliers"
    DIVERGED = "diverged"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tracked:
    """A frame with a pose.

    Attributes:
        t_ns: exposure of the middle row.
        T_world_cam: the pose then.
        cov_cam: covariance (6, 6) of the right tangent (rotation in rad first, then translation),
            in the camera frame, or None where it was not computed.
        map_id: which map the pose is in.
        is_relocalised: whether the track was lost just before.
    """

    t_ns: int
    T_world_cam: Pose[World, Cam]
    cov_cam: FloatArray | None = None
    map_id: int = 0
    is_relocalised: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Lost:
    """A frame without a pose."""

    t_ns: int
    reason: LostReason


TrackingOutcome = Tracked | Lost


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trajectory:
    """Poses of the head camera over time, one for each tracked frame.

    Attributes:
        t_ns: (N,) strictly increasing.
        quat_xyzw: (N, 4) of `R_world_cam`.
        p_world_cam: (N, 3) camera centres in world.
        scale: whether lengths are metres.
        map_id: which map the poses are in.
    """

    t_ns: IntArray
    quat_xyzw: FloatArray
    p_world_cam: FloatArray
    scale: Scale
    map_id: int = 0

    def __post_init__(self) -> None:
        """Copy the arrays read-only and check them."""
        object.__setattr__(self, "t_ns", frozen_ints(self.t_ns, (None,), name="t_ns"))
        count = len(self.t_ns)
        quat = frozen_floats(self.quat_xyzw, (count, 4), name="quat_xyzw")
        object.__setattr__(self, "quat_xyzw", quat)
        position = frozen_floats(self.p_world_cam, (count, 3), name="p_world_cam")
        object.__setattr__(self, "p_world_cam", position)
        if (np.diff(self.t_ns) <= 0).any():
            raise ConventionError("Trajectory.t_ns: strictly increasing times expected")

    @staticmethod
    def from_outcomes(outcomes: "list[Tracked]", *, scale: Scale) -> "Trajectory":
        """Return the path of tracked frames in time order."""
        return Trajectory(
            t_ns=np.array([o.t_ns for o in outcomes], dtype=np.int64),
            quat_xyzw=np.array([o.T_world_cam.quat_xyzw for o in outcomes]).reshape(-1, 4),
            p_world_cam=np.array([o.T_world_cam.t for o in outcomes]).reshape(-1, 3),
            scale=scale,
            map_id=outcomes[0].map_id if outcomes else 0,
        )

    def __len__(self) -> int:
        return len(self.t_ns)

    def carrying(self, T_cam_other: Pose[Cam, GazeCam]) -> "Trajectory":
        """Return the path of another camera that is fixed to this one."""
        R_world_cam = Rotation.from_quat(self.quat_xyzw.copy())
        return replace(
            self,
            quat_xyzw=(R_world_cam * Rotation.from_matrix(T_cam_other.R)).as_quat(),
            p_world_cam=self.p_world_cam + R_world_cam.apply(T_cam_other.t.copy()),
        )

    def pose(self, i: int) -> Pose[World, Cam]:
        """Return the pose of row i."""
        return Pose.from_quat_xyzw(self.quat_xyzw[i], self.p_world_cam[i])

    def at(self, t_ns: int, *, max_gap_ns: int = 150_000_000) -> Pose[World, Cam] | None:
        """Return the interpolated pose; None outside the path or in a gap over max_gap_ns."""
        i = int(np.searchsorted(self.t_ns, t_ns))
        if i < len(self) and self.t_ns[i] == t_ns:
            return self.pose(i)
        if i in (0, len(self)) or self.t_ns[i] - self.t_ns[i - 1] > max_gap_ns:
            return None
        span = int(self.t_ns[i] - self.t_ns[i - 1])
        a = (t_ns - int(self.t_ns[i - 1])) / span
        turn = Slerp([0.0, 1.0], Rotation.from_quat(self.quat_xyzw[i - 1 : i + 1]))
        position = (1 - a) * self.p_world_cam[i - 1] + a * self.p_world_cam[i]
        return Pose(R=turn(a).as_matrix(), t=position)
