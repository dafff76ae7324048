"""The focal length, refined where a recording tells it better than its calibration.

Keyframes and points are adjusted with the focal length free; it is believed only where that
explains the views far better than noise could, and changes it by more than a calibration is off.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.camera import Camera
from gazemap.slam.bundle import BundleProblem, BundleSolution, adjust

_LEAST_CHANGE: Final = 0.005
_LARGEST_CHANGE: Final = 0.15
# Twice the drop of the cost over the variance: the square of ten standard deviations.
_LEAST_EVIDENCE: Final = 100.0


@dataclass(frozen=True, slots=True, kw_only=True)
class FocalEstimate:
    """How many times longer the focal length is than it was said to be, and the evidence."""

    factor: float
    evidence: float

    @property
    def is_significant(self) -> bool:
        """Whether the views demand it, and it is more than a calibration is off anyway."""
        change = abs(self.factor - 1)
        return self.evidence > _LEAST_EVIDENCE and _LEAST_CHANGE < change < _LARGEST_CHANGE


def estimate_focal(problem: BundleProblem) -> FocalEstimate:
    """Return the focal length that explains the views of an adjusted map best."""
    before = _offsets(problem, _as_it_is(problem))
    solved = adjust(replace(problem, refine_focal=True))
    after = _offsets(problem, solved)
    cauchy = problem.cauchy_px / problem.focal_px
    variance = float(np.median((after**2).sum(axis=1))) / 1.386
    drop = _cost(before, cauchy) - _cost(after, cauchy)
    return FocalEstimate(factor=solved.focal_factor, evidence=drop / max(variance, 1e-18))


def with_focal(camera: Camera, factor: float) -> Camera:
    """Return a camera whose focal lengths are so many times longer."""
    K = np.array(camera.K)
    K[0, :2] *= [factor, factor]
    K[1, 1] *= factor
    return replace(camera, K=K)


def _as_it_is(problem: BundleProblem) -> BundleSolution:
    return BundleSolution(
        R_cam_map=problem.R_cam_map, t_cam_map=problem.t_cam_map, points_map=problem.points_map
    )


def _offsets(problem: BundleProblem, solved: BundleSolution) -> FloatArray:
    """Return how far views (M, 2) are from their points, in flat units of the problem."""
    k, points = problem.camera_index, solved.points_map[problem.point_index]
    in_cam = np.einsum("nij,nj->ni", solved.R_cam_map[k], points) + solved.t_cam_map[k]
    off: FloatArray = solved.focal_factor * in_cam[:, :2] / in_cam[:, 2:] - problem.flat
    return off


def _cost(off: FloatArray, cauchy: float) -> float:
    """Return twice the robust cost in squared flat units."""
    return float(cauchy**2 * np.log1p((off**2).sum(axis=1) / cauchy**2).sum())
