"""The pose of one camera from points it sees: robust Gauss-Newton, compiled.

Tangents are left ones of `T_cam_map`, rotation first; views are flat, x/z and y/z.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from gazemap.geometry.arrays import BoolArray, FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PoseFit:
    """A pose as the points want it.

    Attributes:
        R_cam_map: (3, 3).
        t_cam_map: (3,) origin of the map in the camera.
        information: (6, 6) of the tangent, in units of 1 / flat^2 with robust weights.
        distance: (N,) flat distance of each view from its point; inf behind the camera.
    """

    R_cam_map: FloatArray
    t_cam_map: FloatArray
    information: FloatArray
    distance: FloatArray

    def inliers(self, radius: float) -> BoolArray:
        """Return which points (N,) lie within a flat radius of their views."""
        return np.asarray(self.distance < radius)


def fit_pose(
    R_cam_map: FloatArray,
    t_cam_map: FloatArray,
    *,
    points_map: FloatArray,
    flat: FloatArray,
    cauchy: float,
    steps: int = 10,
) -> PoseFit:
    """Return the pose that minimises the Cauchy loss of the reprojection.

    Args:
        R_cam_map: (3, 3) where to start.
        t_cam_map: (3,) where to start.
        points_map: (N, 3).
        flat: (N, 2) their views as x/z, y/z.
        cauchy: scale of the loss, in flat units; it starts at eight times that, so that a start
            that is a few pixels off still counts its points.
        steps: at most so many.
    """
    R, t = R_cam_map.copy(), t_cam_map.copy()
    views = _Views(
        points=np.ascontiguousarray(points_map),
        flat=np.ascontiguousarray(flat),
        distance=np.empty(len(flat)),
    )
    information = _descend(R, t, views, cauchy, steps)
    return PoseFit(R_cam_map=R, t_cam_map=t, information=information, distance=views.distance)


class _Views(NamedTuple):
    """Points (N, 3), their views (N, 2), and how far those are off (N,), which is set."""

    points: FloatArray
    flat: FloatArray
    distance: FloatArray


@njit(cache=True)
def _descend(R: FloatArray, t: FloatArray, views: _Views, cauchy: float, steps: int) -> FloatArray:
    information = np.zeros((6, 6))
    for step in range(steps):
        scale = cauchy * max(1.0, 8.0 * 0.5**step)
        gradient = _normal_equations(R, t, views, scale, information)
        damped = information.copy()
        for k in range(6):
            damped[k, k] += 1e-9 * information[k, k] + 1e-12
        delta: FloatArray = np.linalg.solve(damped, -gradient).astype(np.float64)
        _move(R, t, delta)
        if step > 3 and np.abs(delta).max() < 1e-8:
            break
    _normal_equations(R, t, views, cauchy, information)
    return information


@njit(cache=True)
def _normal_equations(
    R: FloatArray, t: FloatArray, views: _Views, cauchy: float, information: FloatArray
) -> FloatArray:
    """Return the gradient (6,) and set the information (6, 6) and the distances."""
    gradient = np.zeros(6)
    information[:] = 0.0
    rows = np.empty((2, 6))
    for j in range(len(views.flat)):
        point = views.points[j]
        x = R[0, 0] * point[0] + R[0, 1] * point[1] + R[0, 2] * point[2] + t[0]
        y = R[1, 0] * point[0] + R[1, 1] * point[1] + R[1, 2] * point[2] + t[1]
        z = R[2, 0] * point[0] + R[2, 1] * point[1] + R[2, 2] * point[2] + t[2]
        if z < 1e-6:
            views.distance[j] = np.inf
            continue
        a, b = x / z, y / z
        e0, e1 = a - views.flat[j, 0], b - views.flat[j, 1]
        square = e0 * e0 + e1 * e1
        views.distance[j] = np.sqrt(square)
        weight = 1.0 / (1.0 + square / (cauchy * cauchy))
        rows[0] = np.array([-a * b, 1.0 + a * a, -b, 1.0 / z, 0.0, -a / z])
        rows[1] = np.array([-1.0 - b * b, a * b, a, 0.0, 1.0 / z, -b / z])
        for k in range(6):
            gradient[k] += weight * (rows[0, k] * e0 + rows[1, k] * e1)
            for m in range(6):
                information[k, m] += weight * (rows[0, k] * rows[0, m] + rows[1, k] * rows[1, m])
    return gradient


@njit(cache=True)
def rotation_of(rotvec: FloatArray) -> FloatArray:
    """Return the rotation matrix (3, 3) of a rotation vector (3,): Rodrigues' formula."""
    w = rotvec
    angle = np.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    cross = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])
    first, second = 1.0, 0.5
    if angle > 1e-8:
        first = np.sin(angle) / angle
        second = (1.0 - np.cos(angle)) / (angle * angle)
    turn: FloatArray = np.eye(3) + first * cross + second * cross @ cross
    return turn


@njit(cache=True)
def _move(R: FloatArray, t: FloatArray, delta: FloatArray) -> None:
    turn = rotation_of(delta[:3])
    R[:] = turn @ R
    t[:] = turn @ t + delta[3:]
    # One Newton step of the polar factor takes out the rounding that products pile up.
    R[:] = 0.5 * R @ (3.0 * np.eye(3) - R.T @ R)
