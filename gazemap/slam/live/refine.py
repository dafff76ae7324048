"""The pose of one frame from points of the map: robust Gauss-Newton on SE(3).

The tangent is that of `T_cam_world` from the left, rotation first. A row that is exposed `dt`
after the frame's time sees the point moved by the camera's twist: the rolling shutter.
"""

from dataclasses import dataclass

import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray
from gazemap.geometry.compiled import compiled
from gazemap.geometry.pose import Cam, Pose, World

# The map's own errors are shared by all points, so a perfect fit is not trusted fully.
_SCATTER_LIMITS = (0.1, 10.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PoseProblem:
    """Points of the map and where the frame shows them.

    Attributes:
        points_world: (N, 3).
        xy: (N, 2) undistorted, x/z and y/z.
        sigma: (N,) standard deviations of xy.
        dt_s: (N,) exposure of each point's row after the frame's time.
        twist: (6,) of `T_cam_world` from the left, a second: rotation, translation.
    """

    points_world: FloatArray
    xy: FloatArray
    sigma: FloatArray
    dt_s: FloatArray
    twist: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PoseFit:
    """A refined pose.

    Attributes:
        T_cam_world: the pose.
        cov_cam: (6, 6) of the left tangent, which equals that of `T_world_cam` from the right.
        error: (N,) residual lengths in standard deviations; infinite behind the camera.
    """

    T_cam_world: Pose[Cam, World]
    cov_cam: FloatArray
    error: FloatArray

    def inliers(self, limit: float) -> BoolArray:
        """Return which points lie within `limit` standard deviations."""
        return np.asarray(self.error < limit)


@compiled
def exp_rotation(w: FloatArray) -> FloatArray:
    """Return the rotation (3, 3) of a vector (3,)."""
    angle = np.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    a, b = 1.0 - angle * angle / 6.0, 0.5 - angle * angle / 24.0
    if angle > 1e-4:
        a, b = np.sin(angle) / angle, (1.0 - np.cos(angle)) / (angle * angle)
    W = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])
    out: FloatArray = np.eye(3) + a * W + b * (W @ W)
    return out


@compiled
def _accumulate(
    q: FloatArray, residual: FloatArray, weight: float, H: FloatArray, g: FloatArray
) -> None:
    """Add one point's 2 rows to the normal equations; q is the point in the camera frame."""
    z = 1.0 / q[2]
    x, y = q[0] * z, q[1] * z
    J = np.empty((2, 6))
    J[0, 0], J[0, 1], J[0, 2], J[0, 3], J[0, 4], J[0, 5] = -x * y, 1 + x * x, -y, z, 0.0, -x * z
    J[1, 0], J[1, 1], J[1, 2], J[1, 3], J[1, 4], J[1, 5] = -1 - y * y, x * y, x, 0.0, z, -y * z
    for a in range(6):
        g[a] += weight * (J[0, a] * residual[0] + J[1, a] * residual[1])
        for b in range(6):
            H[a, b] += weight * (J[0, a] * J[0, b] + J[1, a] * J[1, b])


@compiled
def _normal_equations(
    R: FloatArray, t: FloatArray, data: FloatArray, twist: FloatArray, cauchy: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    H, g = np.zeros((6, 6)), np.zeros(6)
    error = np.full(len(data), np.inf)
    residual = np.empty(2)
    for j in range(len(data)):
        q = R @ data[j, :3] + t
        dt = data[j, 6]
        q = q + dt * (np.cross(twist[:3], q) + twist[3:])
        if q[2] < 1e-6:
            continue
        residual[0] = q[0] / q[2] - data[j, 3]
        residual[1] = q[1] / q[2] - data[j, 4]
        scale = 1.0 / data[j, 5]
        square = (residual[0] ** 2 + residual[1] ** 2) * scale * scale
        error[j] = np.sqrt(square)
        weight = scale * scale / (1.0 + square / (cauchy * cauchy))
        _accumulate(q, residual, weight, H, g)
    return H, g, error


@compiled
def _gauss_newton(
    R: FloatArray, t: FloatArray, data: FloatArray, twist: FloatArray, cauchy: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    for _ in range(12):
        H, g, error = _normal_equations(R, t, data, twist, cauchy)
        for a in range(6):
            H[a, a] += 1e-9 * H[a, a] + 1e-12
        step = -np.linalg.solve(H, g)
        turn = exp_rotation(step[:3])
        R = turn @ R
        t = turn @ t + step[3:]
        if np.abs(step).max() < 1e-7:
            break
    H, g, error = _normal_equations(R, t, data, twist, cauchy)
    return R, t, H, error


def refine_pose(
    start: Pose[Cam, World], problem: PoseProblem, *, cauchy: float = 2.0
) -> PoseFit | None:
    """Return the pose that fits the points best, or None where the equations are singular.

    Args:
        start: a first guess.
        problem: points and measurements, at least 4.
        cauchy: the robust loss's scale in standard deviations.
    """
    if len(problem.xy) < 4:
        return None
    data = np.column_stack([problem.points_world, problem.xy, problem.sigma, problem.dt_s])
    try:
        R, t, H, error = _gauss_newton(start.R, start.t, data, problem.twist, cauchy)
        cov = np.linalg.inv(H + 1e-9 * np.diag(np.diag(H)) + 1e-12 * np.eye(6))
    except (np.linalg.LinAlgError, ZeroDivisionError):
        return None
    if not (np.isfinite(R).all() and np.isfinite(t).all() and np.isfinite(cov).all()):
        return None
    # The median of a squared Rayleigh variable is 1.386: what the points really scatter by.
    scatter = float(np.clip(np.median(error) ** 2 / 1.386, *_SCATTER_LIMITS))
    U, _, Vt = np.linalg.svd(R)
    return PoseFit(
        T_cam_world=Pose(R=U @ Vt, t=t),
        cov_cam=scatter * np.asarray(cov, dtype=np.float64),
        error=error,
    )
