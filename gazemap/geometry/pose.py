"""Rigid transforms whose frames mypy checks."""

from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from gazemap.errors import ConventionError
from gazemap.geometry.arrays import FloatArray, frozen_floats


class World:
    """Fixed to the table, z up; set by the tag layout where there is one."""


class Cam:
    """A camera's optical frame: x right, y down, z forward."""


class GazeCam:
    """The eye tracker's own camera, where the head camera is another one."""


class Overhead:
    """The overhead camera's optical frame."""


class Tag:
    """A tag: x right and y up as printed, z out of the paper."""


class Body:
    """An object: origin in the centre of its volume."""


A = TypeVar("A")
B = TypeVar("B")
C = TypeVar("C")

_ORTHONORMAL_TOLERANCE = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False)
class Pose(Generic[A, B]):
    """`T_a_b`: maps points of frame b into frame a.

    Attributes:
        R: rotation (3, 3), orthonormal with determinant 1.
        t: origin of b written in a (3,), metres where the scale is metric.
    """

    R: FloatArray
    t: FloatArray

    def __post_init__(self) -> None:
        """Copy the arrays read-only and check them."""
        object.__setattr__(self, "R", frozen_floats(self.R, (3, 3), name="Pose.R"))
        object.__setattr__(self, "t", frozen_floats(self.t, (3,), name="Pose.t"))
        off = float(np.abs(self.R @ self.R.T - np.eye(3)).max())
        if off > _ORTHONORMAL_TOLERANCE or np.linalg.det(self.R) < 0:
            raise ConventionError(f"Pose.R: a rotation expected, off by {off:.2g}")

    @staticmethod
    def identity() -> "Pose[A, B]":
        """Return the pose that changes nothing."""
        return Pose(R=np.eye(3), t=np.zeros(3))

    @staticmethod
    def from_matrix(matrix: ArrayLike) -> "Pose[A, B]":
        """Return the pose of a homogeneous matrix (4, 4)."""
        full = frozen_floats(matrix, (4, 4), name="matrix")
        return Pose(R=full[:3, :3], t=full[:3, 3])

    @staticmethod
    def from_quat_xyzw(quat_xyzw: ArrayLike, t: ArrayLike) -> "Pose[A, B]":
        """Return the pose of a quaternion (4,) in the order x, y, z, w and an origin (3,)."""
        quat = frozen_floats(quat_xyzw, (4,), name="quat_xyzw")
        return Pose(R=Rotation.from_quat(quat).as_matrix(), t=np.asarray(t, dtype=np.float64))

    @staticmethod
    def from_rotvec(rotvec_rad: ArrayLike, t: ArrayLike) -> "Pose[A, B]":
        """Return the pose of a rotation vector (3,) in radians and an origin (3,)."""
        rotvec = frozen_floats(rotvec_rad, (3,), name="rotvec_rad")
        # scipy refuses read-only rotation vectors.
        return Pose(
            R=Rotation.from_rotvec(rotvec.copy()).as_matrix(), t=np.asarray(t, dtype=np.float64)
        )

    def __matmul__(self, other: "Pose[B, C]") -> "Pose[A, C]":
        """Compose: `T_a_c = T_a_b @ T_b_c`."""
        return Pose(R=_orthonormal(self.R @ other.R), t=self.R @ other.t + self.t)

    def inverse(self) -> "Pose[B, A]":
        """Return `T_b_a`."""
        return Pose(R=self.R.T, t=-self.R.T @ self.t)

    def transform(self, points_b: FloatArray) -> FloatArray:
        """Map points (..., 3) of frame b into frame a."""
        moved: FloatArray = points_b @ self.R.T + self.t
        return moved

    def rotate(self, directions_b: FloatArray) -> FloatArray:
        """Turn directions (..., 3) of frame b into frame a."""
        turned: FloatArray = directions_b @ self.R.T
        return turned

    @property
    def quat_xyzw(self) -> FloatArray:
        """The rotation as a quaternion (4,) in the order x, y, z, w, with w not negative."""
        return np.asarray(Rotation.from_matrix(self.R).as_quat(canonical=True), dtype=np.float64)

    @property
    def rotvec_rad(self) -> FloatArray:
        """The rotation as a vector (3,): axis times angle in radians."""
        return np.asarray(Rotation.from_matrix(self.R).as_rotvec(), dtype=np.float64)

    @property
    def matrix(self) -> FloatArray:
        """The homogeneous matrix (4, 4)."""
        full = np.eye(4)
        full[:3, :3], full[:3, 3] = self.R, self.t
        return full


def _orthonormal(R: FloatArray) -> FloatArray:
    """Take out the rounding that long products pile up: one Newton step of the polar factor."""
    closer: FloatArray = 0.5 * R @ (3.0 * np.eye(3) - R.T @ R)
    return closer
