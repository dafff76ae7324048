"""The read-out time of a rolling shutter, found while the camera is tracked."""

from typing import Final

import numpy as np

from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.live.refine import PoseProblem
from gazemap.slam.rolling_shutter import ShutterEvidence

_FEWEST_FRAMES: Final = 20
_MOST_FRAMES: Final = 640
_ASKED_EVERY: Final = 10
_FEWEST_POINTS: Final = 25
_CAUCHY_PX: Final = 1.0
# Neighbouring frames err alike, so what looks like ten standard deviations is fewer.
_LEAST_SIGMAS: Final = 10.0
_LEAST_S: Final = 0.002
_LONGEST_S: Final = 0.05


class ShutterWatch:
    """Looks for what a read-out time would explain; the camera's own is never touched."""

    def __init__(self, camera: Camera) -> None:
        """Watch only where the camera does not tell its read-out time."""
        self.camera = camera
        self._is_open = camera.readout_s is None
        self._unit = camera.with_readout(1.0)
        self._evidence = ShutterEvidence()
        self._frames = 0
        self._fewest = _FEWEST_FRAMES

    def observe(
        self, T_cam_world: Pose[Cam, World], problem: PoseProblem, v_px: FloatArray
    ) -> None:
        """Take a frame's pose, its points with their views, and the views' rows (N,)."""
        if not self._is_open or len(v_px) < _FEWEST_POINTS or not problem.twist.any():
            return
        in_cam = T_cam_world.transform(problem.points_world)
        turn, slide = problem.twist[:3], problem.twist[3:]
        then = in_cam + problem.dt_s[:, None] * (np.cross(turn, in_cam) + slide)
        if (then[:, 2] < 1e-6).any() or (in_cam[:, 2] < 1e-6).any():
            return
        self._evidence.add(
            in_cam,
            (problem.xy - then[:, :2] / then[:, 2:]).ravel(),
            twist=problem.twist,
            unit_delay_s=self._unit.row_delay_ns(v_px) * 1e-9,
            cauchy=_CAUCHY_PX / float(self.camera.K[0, 0]),
        )
        self._frames += 1
        if self._frames >= self._fewest and self._frames % _ASKED_EVERY == 0:
            self._ask()

    def _ask(self) -> None:
        estimate = self._evidence.estimate()
        if abs(estimate.extra_s) < max(_LEAST_SIGMAS * estimate.sigma_s, _LEAST_S):
            return
        readout_s = (self.camera.readout_s or 0.0) + estimate.extra_s
        self.camera = self.camera.with_readout(float(np.clip(readout_s, -_LONGEST_S, _LONGEST_S)))
        self._evidence, self._frames = ShutterEvidence(), 0
        # Each answer is worth more frames than the one before: it settles.
        self._fewest = min(2 * self._fewest, _MOST_FRAMES)
