"""Camera models: OpenCV's pinhole (4, 5, 8, 12 or 14 coefficients), Kannala-Brandt fisheye."""

from dataclasses import dataclass, replace
from enum import StrEnum

import cv2
import numpy as np

from gazemap.errors import ConventionError
from gazemap.geometry.arrays import FloatArray, check_shape, frozen_floats

_PINHOLE_COEFFICIENT_COUNTS = (0, 4, 5, 8, 12, 14)
# Enough steps to invert strong lenses to 1e-12; the default of OpenCV stops after five.
_UNDISTORT_CRITERIA = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 200, 1e-12)


class LensModel(StrEnum):
    """How a lens bends rays."""

    PINHOLE = "pinhole"
    FISHEYE = "fisheye"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Camera:
    """One calibrated camera; pixel (0, 0) is the centre of the top-left pixel.

    Attributes:
        width_px: width of the image.
        height_px: height of the image.
        K: camera matrix (3, 3) in pixels.
        distortion: coefficients in OpenCV's order: 0, 4, 5, 8, 12 or 14 for a pinhole,
            4 for a fisheye.
        lens: the lens model.
        serial: serial number, or empty.
        readout_s: time from the exposure of the first row to the last; None where unknown.
    """

    width_px: int
    height_px: int
    K: FloatArray
    distortion: FloatArray
    lens: LensModel = LensModel.PINHOLE
    serial: str = ""
    readout_s: float | None = None

    def __post_init__(self) -> None:
        """Copy the arrays read-only and check them."""
        object.__setattr__(self, "K", frozen_floats(self.K, (3, 3), name="Camera.K"))
        flat = np.asarray(self.distortion, dtype=np.float64).ravel()
        object.__setattr__(self, "distortion", frozen_floats(flat, (None,), name="distortion"))
        allowed = (4,) if self.lens is LensModel.FISHEYE else _PINHOLE_COEFFICIENT_COUNTS
        if len(flat) not in allowed:
            raise ConventionError(
                f"{self.lens} lens: {allowed} coefficients expected, got {len(flat)}"
            )
        if self.K[0, 0] <= 0 or self.K[1, 1] <= 0:
            raise ConventionError(
                f"Camera.K: focal lengths must be positive, got {self.K.tolist()}"
            )

    def project(self, points_cam: FloatArray) -> FloatArray:
        """Return pixels (N, 2) of points (N, 3) in the camera frame; NaN where not in front."""
        check_shape(points_cam, (None, 3), name="points_cam")
        uv_px = np.full((len(points_cam), 2), np.nan)
        front = points_cam[:, 2] > 1e-9
        if front.any():
            points = np.ascontiguousarray(points_cam[front], dtype=np.float64).reshape(-1, 1, 3)
            uv_px[front] = self._project_opencv(points)
        return uv_px

    def _project_opencv(self, points_cam: FloatArray) -> FloatArray:
        zero = np.zeros(3)
        if self.lens is LensModel.FISHEYE:
            projected = cv2.fisheye.projectPoints(points_cam, zero, zero, self.K, self.distortion)[
                0
            ]
        else:
            projected = cv2.projectPoints(points_cam, zero, zero, self.K, self.distortion)[0]
        return np.asarray(projected, dtype=np.float64).reshape(-1, 2)

    def normalize(self, uv_px: FloatArray) -> FloatArray:
        """Return x/z, y/z (N, 2) of the rays through pixels (N, 2)."""
        check_shape(uv_px, (None, 2), name="uv_px")
        if len(uv_px) == 0:
            return np.empty((0, 2))
        pixels = np.ascontiguousarray(uv_px, dtype=np.float64).reshape(-1, 1, 2)
        if self.lens is LensModel.FISHEYE:
            flat = cv2.fisheye.undistortPoints(
                pixels, self.K, self.distortion, criteria=_UNDISTORT_CRITERIA
            )
        else:
            flat = cv2.undistortPoints(
                pixels, self.K, self.distortion, None, None, None, _UNDISTORT_CRITERIA
            )
        return np.asarray(flat, dtype=np.float64).reshape(-1, 2)

    def unproject(self, uv_px: FloatArray) -> FloatArray:
        """Return unit directions (N, 3) in the camera frame of the rays through pixels (N, 2)."""
        flat = self.normalize(uv_px)
        rays_cam = np.column_stack([flat, np.ones(len(flat))])
        unit: FloatArray = rays_cam / np.linalg.norm(rays_cam, axis=1, keepdims=True)
        return unit

    def contains(self, uv_px: FloatArray) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Return which pixels (N, 2) lie in the image (N,); NaN lies outside."""
        u, v = uv_px[:, 0], uv_px[:, 1]
        inside = (u >= -0.5) & (u < self.width_px - 0.5) & (v >= -0.5) & (v < self.height_px - 0.5)
        return np.asarray(inside)

    def row_delay_ns(self, v_px: FloatArray) -> FloatArray:
        """Return when rows (N,) are exposed after the frame's time, which is the middle row's."""
        readout_ns = (self.readout_s or 0.0) * 1e9
        delay: FloatArray = (np.asarray(v_px) / max(self.height_px - 1, 1) - 0.5) * readout_ns
        return delay

    def with_readout(self, readout_s: float | None) -> "Camera":
        """Return the same camera with another read-out time."""
        return replace(self, readout_s=readout_s)
