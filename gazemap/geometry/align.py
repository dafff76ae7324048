"""Similarities: what maps one world onto another where rotation, origin and scale differ."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from gazemap.errors import ConventionError
from gazemap.geometry.arrays import FloatArray, frozen_floats
from gazemap.geometry.pose import Pose

A = TypeVar("A")
B = TypeVar("B")
C = TypeVar("C")


@dataclass(frozen=True, kw_only=True, eq=False)
class Similarity(Generic[A, B]):
    """`S_a_b`: maps points of frame b into frame a as `scale * R @ p + t`.

    Attributes:
        scale: length in a over length in b, positive.
        R: rotation (3, 3).
        t: origin of b written in a (3,).
    """

    scale: float
    R: FloatArray
    t: FloatArray

    def __post_init__(self) -> None:
        """Copy the arrays read-only and check them."""
        object.__setattr__(self, "R", frozen_floats(self.R, (3, 3), name="Similarity.R"))
        object.__setattr__(self, "t", frozen_floats(self.t, (3,), name="Similarity.t"))
        if not (np.isfinite(self.scale) and self.scale > 0):
            raise ConventionError(f"Similarity.scale: positive expected, got {self.scale}")

    @staticmethod
    def identity() -> "Similarity[A, B]":
        """Return the similarity that changes nothing."""
        return Similarity(scale=1.0, R=np.eye(3), t=np.zeros(3))

    def transform(self, points_b: FloatArray) -> FloatArray:
        """Map points (..., 3) of frame b into frame a."""
        moved: FloatArray = self.scale * points_b @ self.R.T + self.t
        return moved

    def transform_pose(self, T_b_c: Pose[B, C]) -> Pose[A, C]:
        """Map a pose of c in b to its pose in a; lengths within c scale with it."""
        return Pose(R=self.R @ T_b_c.R, t=self.transform(T_b_c.t))

    def inverse(self) -> "Similarity[B, A]":
        """Return `S_b_a`."""
        return Similarity(scale=1 / self.scale, R=self.R.T, t=-self.R.T @ self.t / self.scale)


def fit_similarity(points_b: FloatArray, points_a: FloatArray) -> Similarity[A, B] | None:
    """Return the least-squares `S_a_b` of points (N, 3); None where they leave it open.

    Source:
        Umeyama 1991, eq. 40 to 42.
    """
    if len(points_b) < 3:
        return None
    mean_b, mean_a = points_b.mean(axis=0), points_a.mean(axis=0)
    left, spread, right = np.linalg.svd((points_a - mean_a).T @ (points_b - mean_b) / len(points_b))
    if spread[1] < 1e-9 * max(spread[0], 1e-300):  # points on one line
        return None
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(left) * np.linalg.det(right))])
    R = (left * sign) @ right
    scale = float((spread * sign).sum() / ((points_b - mean_b) ** 2).sum(axis=1).mean())
    return Similarity(scale=scale, R=R, t=mean_a - scale * R @ mean_b)


def fit_similarity_of_poses(
    poses_b: Sequence[Pose[B, C]], poses_a: Sequence[Pose[A, C]]
) -> Similarity[A, B] | None:
    """Return the `S_a_b` under which poses of the same cameras agree; None without a baseline.

    Rotations come from the orientations, so that two cameras are enough; the scale is that of
    the centres.
    """
    if len(poses_b) < 2:
        return None
    turns = [T_a.R @ T_b.R.T for T_a, T_b in zip(poses_a, poses_b, strict=True)]
    left, _, right = np.linalg.svd(np.sum(turns, axis=0))
    R = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    centres_a, centres_b = np.array([T.t for T in poses_a]), np.array([T.t for T in poses_b])
    mean_a, mean_b = centres_a.mean(axis=0), centres_b.mean(axis=0)
    arms_b = (centres_b - mean_b) @ R.T
    spread = float((arms_b**2).sum())
    scale = float((arms_b * (centres_a - mean_a)).sum()) / max(spread, 1e-300)
    if not (spread > 1e-18 and scale > 1e-9):
        return None
    return Similarity(scale=scale, R=R, t=mean_a - scale * R @ mean_b)
