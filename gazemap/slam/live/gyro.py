"""How the camera turns, from a gyroscope whose mounting and bias are found while it runs.

The axes of a head-worn IMU against its camera are seldom told, and its bias is not constant. Both
follow from comparing how the camera was seen to turn with what the gyroscope said meanwhile; until
they fit, and whenever they stop fitting, the gyroscope is not used.
"""

from collections import deque
from dataclasses import dataclass
from typing import Final

import numpy as np

from gazemap.geometry.arrays import FloatArray
from gazemap.types.session import ImuSample

_KEPT_NS: Final = 2_000_000_000
_LARGEST_GAP_NS: Final = 50_000_000
_PAIRS_KEPT: Final = 300
_FEWEST_PAIRS: Final = 45
_SOLVED_EVERY: Final = 15
# Turns about two axes at least, so fast in the root mean square.
_LEAST_EXCITATION_RAD_S: Final = 0.08
_WORST_SHARE: Final = 0.3
_ROUNDS: Final = 2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mounting:
    """How a gyroscope's rate becomes the camera's: `R_cam_imu @ (rate_imu - bias_imu)`."""

    R_cam_imu: FloatArray
    bias_imu: FloatArray


class Gyroscope:
    """The latest samples, and how the gyroscope sits on the camera."""

    def __init__(self) -> None:
        """Start without samples."""
        self._t_ns: deque[int] = deque()
        self._rate_imu: deque[tuple[float, float, float]] = deque()
        self._pairs: deque[FloatArray] = deque(maxlen=_PAIRS_KEPT)
        self._learnt = 0
        self.mounting: Mounting | None = None

    def add(self, sample: ImuSample) -> None:
        """Take a sample; one that is older than the last is left out."""
        if self._t_ns and sample.t_ns <= self._t_ns[-1]:
            return
        self._t_ns.append(sample.t_ns)
        self._rate_imu.append(sample.gyro_rad_s)
        while self._t_ns[-1] - self._t_ns[0] > _KEPT_NS:
            self._t_ns.popleft()
            self._rate_imu.popleft()

    def turn_rate(self, from_ns: int, to_ns: int) -> FloatArray | None:
        """Return how `T_cam_world` turns from the left (3,), rad/s in the mean between two times.

        None where no samples cover the time, or the mounting is not known.
        """
        rate_imu = self._mean_rate(from_ns, to_ns)
        if rate_imu is None or self.mounting is None:
            return None
        rate: FloatArray = -self.mounting.R_cam_imu @ (rate_imu - self.mounting.bias_imu)
        return rate

    def learn(self, from_ns: int, to_ns: int, turn_rate: FloatArray) -> None:
        """Take how `T_cam_world` was seen to turn from the left (3,), rad/s, between two times."""
        rate_imu = self._mean_rate(from_ns, to_ns)
        if rate_imu is None:
            return
        self._pairs.append(np.stack([rate_imu, -turn_rate]))
        self._learnt += 1
        if len(self._pairs) >= _FEWEST_PAIRS and self._learnt % _SOLVED_EVERY == 0:
            self.mounting = solve_mounting(np.array(self._pairs))

    def _mean_rate(self, from_ns: int, to_ns: int) -> FloatArray | None:
        """Return the mean rate (3,) by the trapezoid rule; None where samples are missing."""
        if len(self._t_ns) < 2 or to_ns <= from_ns:
            return None
        t_ns = np.array(self._t_ns)
        first = max(int(np.searchsorted(t_ns, from_ns, side="right")) - 1, 0)
        last = min(int(np.searchsorted(t_ns, to_ns)), len(t_ns) - 1)
        if t_ns[first] > from_ns or to_ns - t_ns[last] > _LARGEST_GAP_NS or last <= first:
            return None
        span_ns = t_ns[first : last + 1]
        if np.diff(span_ns).max() > _LARGEST_GAP_NS:
            return None
        rates = np.array([self._rate_imu[n] for n in range(first, last + 1)])
        at = np.unique(np.clip(np.concatenate([[from_ns], span_ns, [to_ns]]), from_ns, to_ns))
        offset_s = (span_ns - from_ns) * 1e-9
        at_s = (at - from_ns) * 1e-9
        fine = np.column_stack([np.interp(at_s, offset_s, rates[:, axis]) for axis in range(3)])
        mean: FloatArray = np.trapezoid(fine, at_s, axis=0) / at_s[-1]
        return mean


def solve_mounting(pairs: FloatArray) -> Mounting | None:
    """Return the mounting that explains pairs (N, 2, 3) of gyroscope and camera rates.

    None where the turns leave it open, or no mounting explains them.

    Source:
        Kabsch 1976 on centred rates; one round of leaving out what does not fit.
    """
    keep = np.ones(len(pairs), dtype=np.bool_)
    off = np.zeros(len(pairs))
    for _ in range(_ROUNDS):
        mounting = _fitted(pairs[keep])
        if mounting is None:
            return None
        off = np.linalg.norm(
            (pairs[:, 0] - mounting.bias_imu) @ mounting.R_cam_imu.T - pairs[:, 1], axis=1
        )
        keep = off < 3.0 * float(np.median(off)) + 1e-9
    mounting = _fitted(pairs[keep])
    turning = float(np.sqrt((pairs[keep, 1] ** 2).sum(axis=1).mean()))
    fits = float(np.sqrt((off[keep] ** 2).mean())) < _WORST_SHARE * turning
    return mounting if fits else None


def _fitted(pairs: FloatArray) -> Mounting | None:
    imu, cam = pairs[:, 0], pairs[:, 1]
    if len(imu) < _FEWEST_PAIRS // 2:
        return None
    middle_imu, middle_cam = imu.mean(axis=0), cam.mean(axis=0)
    left, spread, right = np.linalg.svd((cam - middle_cam).T @ (imu - middle_imu) / len(imu))
    if spread[1] < _LEAST_EXCITATION_RAD_S**2:
        return None
    R = (left * [1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
    return Mounting(R_cam_imu=R, bias_imu=middle_imu - R.T @ middle_cam)
