"""How the head moves: it turns part of the way after the eyes, sways and leans."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d

from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.sim.eyes import Look

_STEP_S = 1.0 / 120.0
_MARGIN_S = 0.5  # the path reaches beyond the session, for exposures at its ends
_STAND_WORLD = np.array([0.0, -0.615, 0.518])
_AIM_WORLD = np.array([0.0, 0.02, 0.0])
_FOLLOW_SHARE = 0.55  # of a gaze shift is done by the head
_LEAN_SHARE = 0.12
_TURN_SIGMA_S, _LEAN_SIGMA_S = 0.26, 0.5
_SWAY_M = np.array([0.038, 0.034, 0.026])
_SWAY_SIGMA_S, _JITTER_SIGMA_S = 0.27, 0.16
_JITTER_M, _ROLL_RAD = 0.022, 0.022


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HeadPath:
    """A smooth path: position, the point on the table under the optical axis, and roll."""

    position: CubicSpline
    aim: CubicSpline
    roll: CubicSpline

    def poses(self, t_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return `R_world_cam` (N, 3, 3) and camera centres in world (N, 3) at times (N,)."""
        centres: FloatArray = self.position(t_s)
        forward = self.aim(t_s) - centres
        forward /= np.linalg.norm(forward, axis=1, keepdims=True)
        level = np.cross(forward, [0.0, 0.0, 1.0])
        level /= np.linalg.norm(level, axis=1, keepdims=True)
        down = np.cross(forward, level)
        roll = self.roll(t_s)[:, None]
        right = np.cos(roll) * level + np.sin(roll) * down
        R: FloatArray = np.stack([right, np.cross(forward, right), forward], axis=2)
        return R, centres

    def T_world_cam(self, t_s: float) -> Pose[World, Cam]:
        """Return the pose at one time."""
        R, centres = self.poses(np.array([t_s]))
        return Pose(R=R[0], t=centres[0])


def move_head(looks: tuple[Look, ...], *, seconds: float, rng: np.random.Generator) -> HeadPath:
    """Draw the head's path for a sequence of fixations."""
    t_s = np.arange(-_MARGIN_S, seconds + _MARGIN_S + _STEP_S, _STEP_S)
    starts = np.array([look.start_s for look in looks])
    points = np.array([look.point_world for look in looks])
    seen = points[np.clip(np.searchsorted(starts, t_s, side="right") - 1, 0, None)]  # (N, 3)
    off = gaussian_filter1d((seen - _AIM_WORLD) * [1.0, 1.0, 0.0], _TURN_SIGMA_S / _STEP_S, axis=0)
    lean = gaussian_filter1d(off, _LEAN_SIGMA_S / _STEP_S, axis=0)
    sway = _smooth_noise(len(t_s), _SWAY_SIGMA_S, rng) * _SWAY_M
    jitter = _smooth_noise(len(t_s), _JITTER_SIGMA_S, rng) * [_JITTER_M, _JITTER_M, 0.0]
    roll = _smooth_noise(len(t_s), _SWAY_SIGMA_S, rng)[:, 0] * _ROLL_RAD
    return HeadPath(
        position=CubicSpline(t_s, _STAND_WORLD + _LEAN_SHARE * lean + sway),
        aim=CubicSpline(t_s, _AIM_WORLD + _FOLLOW_SHARE * off + jitter),
        roll=CubicSpline(t_s, roll),
    )


def _smooth_noise(count: int, sigma_s: float, rng: np.random.Generator) -> FloatArray:
    """Return noise (count, 3) of standard deviation 1 without fast parts."""
    sigma = sigma_s / _STEP_S
    smooth: FloatArray = gaussian_filter1d(rng.normal(size=(count, 3)), sigma, axis=0)
    return np.asarray(smooth * np.sqrt(2.0 * sigma * np.sqrt(np.pi)))
