"""Fits a box to what several views see of one thing.

A box divides every cut-out into inside and outside of its silhouette. The best box is the one
whose division the colours explain best: the colours inside and outside are learnt from the
division itself, so nothing is assumed about which colours a thing or a table has.

Source:
    Region-based pose estimation as in Prisacariu and Reid 2012 (PWP3D), with the box's size as
    further unknowns and several views; optimised without derivatives.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from gazemap.geometry.arrays import FloatArray
from gazemap.scene.colours import ColourDivision, ColourModel
from gazemap.scene.config import BoxFitConfig
from gazemap.scene.silhouette import sum_inside
from gazemap.scene.simplex import climb

_ROUNDS = 3
_LEAST_HEIGHT_M = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Box:
    """An upright box in world.

    Attributes:
        centre: (3,) of its volume, metres.
        yaw_rad: heading of its length about z.
        size_m: (3,) length, width, height.
    """

    centre: FloatArray
    yaw_rad: float
    size_m: FloatArray

    @property
    def shape(self) -> FloatArray:
        """The seven numbers that `silhouette` takes."""
        return np.array([*self.centre, self.yaw_rad, *self.size_m])

    @staticmethod
    def from_shape(shape: FloatArray) -> "Box":
        """Return the box of seven numbers."""
        return Box(centre=shape[:3].copy(), yaw_rad=float(shape[3]), size_m=shape[4:7].copy())

    def standing_on(self, base_m: float, height_m: float) -> "Box":
        """Return the box of another height on another level."""
        return Box(
            centre=np.array([*self.centre[:2], base_m + height_m / 2]),
            yaw_rad=self.yaw_rad,
            size_m=np.array([*self.size_m[:2], height_m]),
        )

    @property
    def base_m(self) -> float:
        """The height it stands on."""
        return float(self.centre[2] - self.size_m[2] / 2)

    @property
    def top_m(self) -> float:
        """The height of its upper side."""
        return float(self.centre[2] + self.size_m[2] / 2)

    def shared_m3(self, other: "Box") -> float:
        """Return the volume that two boxes share; solid things share none."""
        height_m = min(self.top_m, other.top_m) - max(self.base_m, other.base_m)
        shared, corners = cv2.rotatedRectangleIntersection(self.plan, other.plan)
        if height_m <= 0 or shared == cv2.INTERSECT_NONE:
            return 0.0
        return float(cv2.contourArea(cv2.convexHull(corners)) * height_m)

    @property
    def plan(self) -> tuple[tuple[float, float], tuple[float, float], float]:
        """The ground plan as OpenCV has it: centre, sides, degrees."""
        (x, y), (length, width) = self.centre[:2].tolist(), self.size_m[:2].tolist()
        return (x, y), (length, width), float(np.degrees(self.yaw_rad))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BoxFit:
    """A fitted box.

    Attributes:
        box: the box.
        cov_world: (3, 3) covariance of its centre, m^2.
        size_sigma_m: standard deviation of each extent.
        log_likelihood: of all cut-outs under their division by the box.
    """

    box: Box
    cov_world: FloatArray
    size_sigma_m: float
    log_likelihood: float


# Which of the shape's seven numbers are searched; z follows from the base and the height.
_ALL = np.array([0, 1, 3, 4, 5, 6])
_PLACE = np.array([0, 1, 3])
_GROUND_PLAN = np.array([0, 1, 3, 4, 5])
_STEPS = np.array([0.004, 0.004, 0.15, 0.006, 0.006, 0.006])


def fit_boxes(division: ColourDivision, starts: list[Box], config: BoxFitConfig) -> list[BoxFit]:
    """Return the box that divides the cut-outs best near each start; its level stays."""
    return [_Search(division, start, config, _ALL).run() for start in starts]


def fit_flat(division: ColourDivision, start: Box, config: BoxFitConfig) -> BoxFit:
    """Return the best mark on the same level: what a box must explain better to be one."""
    flat = start.standing_on(start.base_m, _LEAST_HEIGHT_M)
    return _Search(division, flat, config, _GROUND_PLAN).run()


def fit_place(
    division: ColourDivision, starts: list[Box], config: BoxFitConfig, inside: ColourModel
) -> BoxFit:
    """Return where a box of known size and colours stands: place and heading alone are searched."""
    fits = [_Search(division, start, config, _PLACE, inside).run() for start in starts]
    return max(fits, key=lambda fit: fit.log_likelihood)


class _Search:
    """Alternates between learning the colours and moving the box."""

    def __init__(
        self,
        division: ColourDivision,
        start: Box,
        config: BoxFitConfig,
        free: np.ndarray[tuple[int], np.dtype[np.int64]],
        inside: ColourModel | None = None,
    ) -> None:
        self._division, self._config, self._inside = division, config, inside
        side, most = config.min_side_m / 2, config.max_plan_m
        least = [side, side, _LEAST_HEIGHT_M]
        self._limits = np.array([least, [most, most, config.max_side_m]])
        self._free, self._base, self._shape = free, start.base_m, start.shape
        self._sums = np.zeros((1, 1, 2))

    def run(self) -> BoxFit:
        for k in range(_ROUNDS):
            odds, _ = self._division.log_odds(self._shape, self._inside)
            self._sums = np.zeros((*odds.shape[:2], odds.shape[2] + 1))
            np.cumsum(odds, axis=2, out=self._sums[:, :, 1:])
            self._move(is_last=k == _ROUNDS - 1)
        return BoxFit(
            box=Box.from_shape(self._shape),
            cov_world=self._covariance(),
            size_sigma_m=float(np.sqrt(2.0)) * self._edge_sigma_m,
            log_likelihood=self._division.log_odds(self._shape, self._inside)[1],
        )

    def _move(self, *, is_last: bool) -> None:
        self._shape = climb(
            (self._free, self._shape, self._limits, self._division.projections, self._sums),
            _STEPS[: len(self._free)],
            2e-4 if is_last else 1e-3,
            300,
        )

    def _gain(self, free: FloatArray) -> float:
        shape = self._shape.copy()
        shape[self._free] = free
        shape[2] = self._base + shape[6] / 2
        return float(sum_inside(shape, self._division.projections, self._sums))

    @property
    def _edge_sigma_m(self) -> float:
        """How far off each side is: more views do not help, for all blur their edges alike."""
        grain_m = float(np.median([c.grain_m for c in self._division.crops]))
        return self._config.edge_sigma_px * grain_m

    def _covariance(self) -> FloatArray:
        """Return the centre's covariance (3, 3) from how sharp the optimum is.

        The sides' errors are independent: half of their variance moves the centre.
        """
        start = self._shape[self._free]
        step = _STEPS[: len(start)] / 2
        peak = self._gain(start)
        variance = np.zeros(7)
        for k, axis in enumerate(np.diag(step)):
            drop = 2 * peak - self._gain(start + axis) - self._gain(start - axis)
            variance[self._free[k]] = step[k] ** 2 / max(drop, 1e-3)
        spread = np.array([variance[0], variance[1], variance[6] / 4])
        edges = self._edge_sigma_m**2 / 2.0
        return np.diag(np.clip(spread, 0, 0.02**2) + edges + self._config.sigma_floor_m**2)
