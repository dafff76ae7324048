"""Bundle adjustment of keyframes and points: robust Levenberg-Marquardt with Schur complement.

Built for the live map: some ten keyframes and a thousand points in some ten milliseconds, where
one graph factor for each measurement takes longer to build than to solve.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, IntArray
from gazemap.geometry.compiled import compiled
from gazemap.slam.live.refine import exp_rotation


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BundleProblem:
    """Keyframes, points and what was measured.

    Attributes:
        R: (K, 3, 3) rotations of `T_cam_world`.
        t: (K, 3) translations of `T_cam_world`.
        twist: (K, 6) of `T_cam_world` from the left, a second.
        keyframe_free: (K,) which keyframes may move.
        points_world: (M, 3).
        point_free: (M,) which points may move; tag corners do not.
        keyframe: (N,) of each measurement, which are sorted by point.
        point: (N,) of each measurement.
        xy: (N, 2) undistorted, x/z and y/z.
        sigma: (N,) standard deviations of xy.
        dt_s: (N,) exposure of the row after the frame's time.
    """

    R: FloatArray
    t: FloatArray
    twist: FloatArray
    keyframe_free: BoolArray
    points_world: FloatArray
    point_free: BoolArray
    keyframe: IntArray
    point: IntArray
    xy: FloatArray
    sigma: FloatArray
    dt_s: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BundleFit:
    """What the adjustment found; `error` (N,) is in standard deviations of each measurement."""

    R: FloatArray
    t: FloatArray
    points_world: FloatArray
    error: FloatArray


class _State(NamedTuple):
    """What is solved for: poses of `T_cam_world` and points."""

    R: FloatArray
    t: FloatArray
    points: FloatArray


class _Data(NamedTuple):
    """What is given: pairs (N, 2) are keyframe and point; rows (N, 4) are x, y, sigma, dt.

    `slot` (K,) numbers the free keyframes, -1 for a fixed one.
    """

    twist: FloatArray
    slot: IntArray
    point_free: BoolArray
    pairs: IntArray
    rows: FloatArray
    cauchy: float


class _Normal(NamedTuple):
    """Normal equations: cameras S, b; points V (M, 3, 4) with the gradient last; cross blocks."""

    S: FloatArray
    b: FloatArray
    V: FloatArray
    cross: FloatArray


@compiled
def _residual(state: _State, data: _Data, n: int, out: FloatArray) -> bool:
    """Fill out with measurement n's point in the camera (3,) and residual (2,)."""
    k, m = data.pairs[n, 0], data.pairs[n, 1]
    R, t, p, w = state.R[k], state.t[k], state.points[m], data.twist[k]
    for a in range(3):
        out[a] = R[a, 0] * p[0] + R[a, 1] * p[1] + R[a, 2] * p[2] + t[a]
    dt = data.rows[n, 3]
    if dt != 0.0:
        x, y, z = out[0], out[1], out[2]
        out[0] += dt * (w[1] * z - w[2] * y + w[3])
        out[1] += dt * (w[2] * x - w[0] * z + w[4])
        out[2] += dt * (w[0] * y - w[1] * x + w[5])
    if out[2] < 1e-6:
        return False
    out[3] = out[0] / out[2] - data.rows[n, 0]
    out[4] = out[1] / out[2] - data.rows[n, 1]
    return True


@compiled
def _errors(state: _State, data: _Data) -> FloatArray:
    """Return residual lengths (N,) in standard deviations; 1e3 behind the camera."""
    error = np.empty(len(data.rows))
    out = np.empty(5)
    for n in range(len(data.rows)):
        if _residual(state, data, n, out):
            error[n] = np.sqrt(out[3] * out[3] + out[4] * out[4]) / data.rows[n, 2]
        else:
            error[n] = 1e3
    return error


@compiled
def _jacobians(q: FloatArray, R: FloatArray, J: FloatArray) -> None:
    """Fill J (2, 9): against the camera's tangent, then against the point in world."""
    z = 1.0 / q[2]
    x, y = q[0] * z, q[1] * z
    J[0, 0], J[0, 1], J[0, 2], J[0, 3], J[0, 4], J[0, 5] = -x * y, 1 + x * x, -y, z, 0.0, -x * z
    J[1, 0], J[1, 1], J[1, 2], J[1, 3], J[1, 4], J[1, 5] = -1 - y * y, x * y, x, 0.0, z, -y * z
    for c in range(3):
        J[0, 6 + c] = z * (R[0, c] - x * R[2, c])
        J[1, 6 + c] = z * (R[1, c] - y * R[2, c])


@compiled
def _add_camera(normal: _Normal, at: int, J: FloatArray, out: FloatArray, weight: float) -> None:
    for a in range(6):
        normal.b[at + a] += weight * (J[0, a] * out[3] + J[1, a] * out[4])
        for c in range(6):
            normal.S[at + a, at + c] += weight * (J[0, a] * J[0, c] + J[1, a] * J[1, c])


@compiled
def _add_point(
    block: FloatArray, J: FloatArray, out: FloatArray, weight: float, cross: FloatArray
) -> None:
    for a in range(3):
        block[a, 3] += weight * (J[0, 6 + a] * out[3] + J[1, 6 + a] * out[4])
        for c in range(3):
            block[a, c] += weight * (J[0, 6 + a] * J[0, 6 + c] + J[1, 6 + a] * J[1, 6 + c])
        for c in range(6):
            cross[c, a] = weight * (J[0, c] * J[0, 6 + a] + J[1, c] * J[1, 6 + a])


@compiled
def _linearise(state: _State, data: _Data) -> _Normal:
    size = 6 * (data.slot.max() + 1)
    normal = _Normal(
        np.zeros((size, size)),
        np.zeros(size),
        np.zeros((len(state.points), 3, 4)),
        np.zeros((len(data.rows), 6, 3)),
    )
    out, J = np.empty(5), np.empty((2, 9))
    for n in range(len(data.rows)):
        k, m = data.pairs[n, 0], data.pairs[n, 1]
        if not _residual(state, data, n, out):
            continue
        _jacobians(out, state.R[k], J)
        precision = 1.0 / (data.rows[n, 2] * data.rows[n, 2])
        square = (out[3] * out[3] + out[4] * out[4]) * precision
        weight = precision / (1.0 + square / (data.cauchy * data.cauchy))
        if data.slot[k] >= 0:
            _add_camera(normal, 6 * data.slot[k], J, out, weight)
        _add_point(normal.V[m], J, out, weight, normal.cross[n])
    return normal


@compiled
def _invert3(block: FloatArray, damping: float, out: FloatArray) -> None:
    a, d, f = block[0, 0], block[1, 1], block[2, 2]
    a, d, f = a + damping * a + 1e-12, d + damping * d + 1e-12, f + damping * f + 1e-12
    b, c, e = block[0, 1], block[0, 2], block[1, 2]
    first, second, third = d * f - e * e, c * e - b * f, b * e - c * d
    scale = 1.0 / (a * first + b * second + c * third)
    out[0, 0], out[0, 1], out[0, 2] = first * scale, second * scale, third * scale
    out[1, 0], out[1, 1], out[1, 2] = out[0, 1], (a * f - c * c) * scale, (b * c - a * e) * scale
    out[2, 0], out[2, 1], out[2, 2] = out[0, 2], out[1, 2], (a * d - b * b) * scale


@compiled
def _take_product(S: FloatArray, half: FloatArray, cross: FloatArray) -> None:
    for a in range(6):
        for e in range(6):
            S[a, e] -= (
                half[a, 0] * cross[e, 0] + half[a, 1] * cross[e, 1] + half[a, 2] * cross[e, 2]
            )


@compiled
def _eliminate(
    system: tuple[FloatArray, FloatArray],
    slots: IntArray,
    cross: FloatArray,
    inverse: FloatArray,
    gradient: FloatArray,
) -> None:
    """Take one point out of the camera system; slots (n,) are its free cameras."""
    S, b = system
    for n in range(len(slots)):
        half = cross[n] @ inverse
        at = 6 * slots[n]
        b[at : at + 6] -= half @ gradient
        for o in range(len(slots)):
            to = 6 * slots[o]
            _take_product(S[at : at + 6, to : to + 6], half, cross[o])


@compiled
def _reduced(
    normal: _Normal, data: _Data, damping: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the damped camera system without the points, and the points' inverses (M, 3, 3)."""
    S, b = normal.S.copy(), normal.b.copy()
    for a in range(len(b)):
        S[a, a] += damping * S[a, a] + 1e-12
    inverse = np.zeros((len(normal.V), 3, 3))
    slots = data.slot[data.pairs[:, 0]]
    starts = np.searchsorted(data.pairs[:, 1], np.arange(len(normal.V) + 1))
    for m in range(len(normal.V)):
        if data.point_free[m] and starts[m] < starts[m + 1]:
            _invert3(normal.V[m], damping, inverse[m])
            free = starts[m] + np.flatnonzero(slots[starts[m] : starts[m + 1]] >= 0)
            gradient = np.ascontiguousarray(normal.V[m, :, 3])
            _eliminate((S, b), slots[free], normal.cross[free], inverse[m], gradient)
    return S, b, inverse


@compiled
def _stepped(state: _State, data: _Data, normal: _Normal, damping: float) -> _State:
    """Return the state after one damped step."""
    S, b, inverse = _reduced(normal, data, damping)
    step = -np.linalg.solve(S, b) if len(b) > 0 else b
    gradient = normal.V[:, :, 3].copy()
    for n in range(len(data.pairs)):
        slot = data.slot[data.pairs[n, 0]]
        if slot >= 0:
            gradient[data.pairs[n, 1]] += normal.cross[n].T @ step[6 * slot : 6 * slot + 6]
    R, t, points = state.R.copy(), state.t.copy(), state.points.copy()
    for m in range(len(points)):
        points[m] -= inverse[m] @ gradient[m]
    for k in range(len(data.slot)):
        if data.slot[k] >= 0:
            at = 6 * data.slot[k]
            turn = exp_rotation(step[at : at + 3])
            R[k] = turn @ R[k]
            t[k] = turn @ t[k] + step[at + 3 : at + 6]
    return _State(R, t, points)


@compiled
def _cost(state: _State, data: _Data) -> float:
    error = _errors(state, data)
    square = data.cauchy * data.cauchy
    total: float = square * np.sum(np.log(1.0 + error * error / square))
    return total


@compiled
def _adjust(state: _State, data: _Data, rounds: int) -> _State:
    damping = 1e-4
    cost = _cost(state, data)
    for _ in range(rounds):
        normal = _linearise(state, data)
        gained = 0.0
        for _ in range(6):
            moved = _stepped(state, data, normal, damping)
            new = _cost(moved, data)
            if new < cost:
                gained = (cost - new) / cost
                state, cost = moved, new
                damping = max(damping * 0.1, 1e-9)
                break
            damping *= 10.0
        if gained < 1e-5:
            break
    return state


def adjust_bundle(problem: BundleProblem, *, cauchy: float = 1.5, rounds: int = 10) -> BundleFit:
    """Return the keyframes and points that fit the measurements best.

    Nothing holds the gauge beyond the damping: fixed keyframes or tag corners do, or the caller.

    Args:
        problem: keyframes, points and measurements.
        cauchy: the robust loss's scale in standard deviations.
        rounds: at most so many linearisations.

    Raises:
        numpy.linalg.LinAlgError: if the camera system is singular.
    """
    slot = np.where(problem.keyframe_free, np.cumsum(problem.keyframe_free) - 1, -1)
    data = _Data(
        twist=np.ascontiguousarray(problem.twist),
        slot=slot.astype(np.int64),
        point_free=problem.point_free,
        pairs=np.ascontiguousarray(np.column_stack([problem.keyframe, problem.point])),
        rows=np.column_stack([problem.xy, problem.sigma, problem.dt_s]),
        cauchy=cauchy,
    )
    start = _State(
        np.array(problem.R), np.array(problem.t), np.array(problem.points_world, dtype=np.float64)
    )
    fit = _adjust(start, data, rounds)
    return BundleFit(R=fit.R, t=fit.t, points_world=fit.points, error=_errors(fit, data))
