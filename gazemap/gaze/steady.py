"""Gaze with the head's motion taken out."""

import numpy as np

from gazemap.gaze.config import FixationConfig
from gazemap.gaze.directions import angles_of, poses_at
from gazemap.gaze.flow import ImageMotion
from gazemap.geometry.arrays import FloatArray, IntArray
from gazemap.types.tracking import Trajectory


class SteadyGaze:
    """Gaze samples with the head's motion taken out."""

    def __init__(
        self,
        t_ns: IntArray,
        directions_cam: FloatArray,
        trajectory: Trajectory | None,
        config: FixationConfig,
        motion: ImageMotion | None = None,
    ) -> None:
        self.t_ns, self._directions = t_ns, directions_cam
        self.R, self.p = np.tile(np.eye(3), (len(t_ns), 1, 1)), np.zeros((len(t_ns), 3))
        is_posed = np.zeros(len(t_ns), dtype=bool)
        if trajectory is not None:
            self.R, self.p, is_posed = poses_at(trajectory, t_ns)
        self._is_posed = is_posed
        rays = np.einsum("nij,nj->ni", self.R, directions_cam)
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = -self.p[:, 2] / rays[:, 2]
        is_near = (reach > 0) & (reach < 3 * config.assumed_distance_m)
        reach = np.where(is_near, reach, config.assumed_distance_m)
        self._reach = reach[:, None] * rays
        self._H, self._reference = np.tile(np.eye(3), (len(t_ns), 1, 1)), np.full(len(t_ns), -1)
        if motion is not None:
            self._H, self._reference = motion.at(t_ns)
        self._H_inverse = np.linalg.inv(self._H)
        self._in_reference = np.einsum("nij,nj->ni", self._H, directions_cam)
        self.period_s = float(np.median(np.diff(t_ns))) * 1e-9

    def seen_from(self, i: IntArray, j: IntArray, *, nearer: float = 1.0) -> FloatArray:
        """Return the angles (..., 2) in degrees at which sample j's point lies for the camera of i.

        Angles are relative to sample i's own camera. Without poses sample j's direction is moved
        as the image did meanwhile, and taken as it is where not even that is known. `nearer`
        scales how far gaze is taken to reach.
        """
        points = self.p[j] + nearer * self._reach[j]
        to_point = np.einsum("...ij,...i->...j", self.R[i], points - self.p[i])
        moved = np.einsum("...ij,...j->...i", self._H_inverse[i], self._in_reference[j])
        is_tied = (self._reference[i] == self._reference[j]) & (self._reference[i] >= 0)
        both = (self._is_posed[i] & self._is_posed[j])[..., None]
        direction = np.where(is_tied[..., None], moved, self._directions[j])
        direction = np.where(both, to_point, direction)
        flat = angles_of(direction.reshape(-1, 3))
        return np.asarray(np.degrees(flat).reshape((*direction.shape[:-1], 2)))
