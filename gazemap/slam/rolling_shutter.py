"""The read-out time of a rolling shutter, from how views miss their points by row and motion."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.camera import Camera
from gazemap.slam.frame_path import FramePath
from gazemap.slam.framewise import FrameViews

_FEWEST_VIEWS: Final = 20
_SMALLEST_S: Final = 0.001
_LONGEST_S: Final = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadoutEstimate:
    """How much longer the shutter reads out than was assumed, and the standard deviation."""

    extra_s: float
    sigma_s: float

    @property
    def is_significant(self) -> bool:
        """Whether it is more than noise, and more than anyone needs to care about."""
        return _LONGEST_S > abs(self.extra_s) > max(5 * self.sigma_s, _SMALLEST_S)


class ShutterEvidence:
    """What frames say about a read-out time; sums only."""

    def __init__(self) -> None:
        """Start without frames."""
        self._explained, self._information, self._squares = 0.0, 0.0, 0.0
        self._count = 0

    def add(
        self,
        in_cam: FloatArray,
        off: FloatArray,
        *,
        twist: FloatArray,
        unit_delay_s: FloatArray,
        cauchy: float,
    ) -> None:
        """Take a frame.

        What a change of its pose could explain as well counts for nothing.

        Args:
            in_cam: (N, 3) points in the camera.
            off: (2 N,) how far their views are off, in flat units, x and y in turn.
            twist: (6,) how the pose changes per second, a left tangent.
            unit_delay_s: (N,) delay of each view's row at a read-out time of one second.
            cauchy: scale of the robust weights, in flat units.
        """
        J = pose_slopes(in_cam)
        weight = np.repeat(1 / (1 + (off.reshape(-1, 2) ** 2).sum(axis=1) / cauchy**2), 2)
        slope = (J @ twist) * np.repeat(unit_delay_s, 2)
        weighted = J * weight[:, None]
        slope = slope - J @ np.linalg.lstsq(weighted.T @ J, weighted.T @ slope, rcond=None)[0]
        self._explained += float(slope @ (weight * off))
        self._information += float(slope @ (weight * slope))
        self._squares += float(off @ (weight * off))
        self._count += len(off)

    def estimate(self) -> ReadoutEstimate:
        """Return the read-out time, beyond the one already taken out, that explains most."""
        if self._information <= 0:
            return ReadoutEstimate(extra_s=0.0, sigma_s=np.inf)
        sigma_s = float(np.sqrt(self._squares / self._count / self._information))
        return ReadoutEstimate(extra_s=self._explained / self._information, sigma_s=sigma_s)


def estimate_readout(
    views: Sequence[FrameViews],
    rows_px: Sequence[FloatArray],
    *,
    path: FramePath,
    points_map: FloatArray,
    camera: Camera,
    cauchy: float,
) -> ReadoutEstimate:
    """Return what read-out time, beyond the one already taken out, explains the residuals best.

    What a change of the frame's pose could explain as well counts for nothing.

    Args:
        views: the found patches of each frame, with the assumed shutter taken out.
        rows_px: their rows (N,), for each frame.
        path: the poses of all frames.
        points_map: (P, 3).
        camera: only its size is used.
        cauchy: scale of the robust weights, in flat units.
    """
    twists = path.twists()
    unit = camera.with_readout(1.0)
    evidence = ShutterEvidence()
    for i in np.flatnonzero(path.is_posed).tolist():
        if len(views[i].point) < _FEWEST_VIEWS:
            continue
        in_cam = points_map[views[i].point] @ path.R_cam_map[i].T + path.t_cam_map[i]
        off = (views[i].flat - in_cam[:, :2] / in_cam[:, 2:]).ravel()
        delay_s = unit.row_delay_ns(rows_px[i]) / 1e9
        evidence.add(in_cam, off, twist=twists[i], unit_delay_s=delay_s, cauchy=cauchy)
    return evidence.estimate()


def pose_slopes(in_cam: FloatArray) -> FloatArray:
    """Return how the views of points (N, 3) change with the pose's left tangent: (2 N, 6)."""
    a, b, inverse_z = in_cam[:, 0] / in_cam[:, 2], in_cam[:, 1] / in_cam[:, 2], 1 / in_cam[:, 2]
    zero = np.zeros(len(in_cam))
    across = np.stack([-a * b, 1 + a * a, -b, inverse_z, zero, -a * inverse_z], axis=1)
    down = np.stack([-1 - b * b, a * b, a, zero, inverse_z, -b * inverse_z], axis=1)
    slopes: FloatArray = np.stack([across, down], axis=1).reshape(-1, 6)
    return slopes
