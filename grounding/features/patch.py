"""A patch with its object's mask, and the measurements that several features share."""

from dataclasses import dataclass
from functools import cache, cached_property
from math import factorial
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from grounding.features.background import Mask
from grounding.types import FloatArray, ImageArray

ZERNIKE_ORDERS: Final = tuple((n, m) for n in range(2, 7) for m in range(n + 1) if (n - m) % 2 == 0)
_PAINT_PIXELS: Final = 400  # are enough for a median
_CONTOUR_SAMPLES: Final = 64


@dataclass(frozen=True, kw_only=True, eq=False)
class MaskedPatch:
    """What a feature is a function of; measurements are made once, when first asked for.

    Attributes:
        image_bgr: (H, W, 3).
        mask: (H, W) the object.
        mm_per_px: the metric scale in the object's plane, or None.
        height_mm: the object's height where the scene gives it, or None.
        white_bgr: how a white surface looks under this light, or None to trust the camera.
        embedding: (E,) of a network that the user supplied, or None.
    """

    image_bgr: ImageArray
    mask: Mask
    mm_per_px: float | None = None
    height_mm: float | None = None
    white_bgr: tuple[float, float, float] | None = None
    embedding: FloatArray | None = None

    @cached_property
    def paint_bgr(self) -> FloatArray:
        """(3,) the object's colour in [0, 1] after white balance.

        The median of the brighter half of its inside: sides in shade and highlights stay out.
        """
        image, mask = self._box
        inside = cv2.erode(mask, np.ones((3, 3), np.uint8)) > 0
        places = np.flatnonzero(inside if np.count_nonzero(inside) >= 9 else mask)
        places = places[:: max(1, len(places) // _PAINT_PIXELS)]
        pixels = image.reshape(-1, 3)[places].astype(np.float32)
        brightness = pixels @ np.ones(3, np.float32)
        ordered = np.sort(brightness)
        half, top = ordered[len(pixels) // 2], ordered[-1 - len(pixels) // 50]
        lit = np.sort(pixels[(brightness >= half) & (brightness <= top)], axis=0)
        median = (lit[(len(lit) - 1) // 2] + lit[len(lit) // 2]) / 2
        white = np.asarray(self.white_bgr or (255.0, 255.0, 255.0))
        colour: FloatArray = median / np.maximum(white, 1.0)
        return np.minimum(colour, 1.0)

    @cached_property
    def mean_bgr(self) -> FloatArray:
        """(3,) the mean colour of all of the object's pixels, grey levels, as in the paper."""
        image, mask = self._box
        return np.array(cv2.mean(image, mask)[:3])

    @cached_property
    def area_px(self) -> float:
        """The object's area in pixels."""
        return float(np.count_nonzero(self.mask))

    @cached_property
    def contour(self) -> NDArray[np.int32]:
        """(N, 1, 2) the outer contour."""
        contours, _ = cv2.findContours(self._box[1], cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        return np.asarray(max(contours, key=len), np.int32)

    @cached_property
    def outline_area_px(self) -> float:
        """The area within the outer contour, holes filled; pixels are counted whole."""
        return cv2.contourArea(self.contour) + len(self.contour) / 2 + 1

    @cached_property
    def sides_px(self) -> tuple[float, float]:
        """The longer and the shorter side of the tightest rectangle, in pixels."""
        _, (width, height), _ = cv2.minAreaRect(self.contour)
        return max(width, height) + 1, min(width, height) + 1

    @cached_property
    def hu(self) -> FloatArray:
        """(7,) Hu's moments of the mask."""
        return np.ravel(cv2.HuMoments(cv2.moments(self._box[1], binaryImage=True)))

    @cached_property
    def _disc_image(self) -> NDArray[np.float32]:
        """(32, 32) the mask, centred on its centroid, its farthest point on the unit circle."""
        mask = self._box[1]
        moments = cv2.moments(mask, binaryImage=True)
        centre = np.array([moments["m10"], moments["m01"]]) / moments["m00"]
        radius = np.linalg.norm(self.contour[:, 0] - centre, axis=1).max() + 0.5
        scale = 15.5 / radius
        affine = np.array(
            [[scale, 0, 15.5 - scale * centre[0]], [0, scale, 15.5 - scale * centre[1]]]
        )
        shrunk = cv2.warpAffine(mask * np.float32(255), affine, (32, 32), flags=cv2.INTER_LINEAR)
        return np.asarray(shrunk, np.float32) / np.float32(255)

    @cached_property
    def zernike(self) -> dict[tuple[int, int], float]:
        """Magnitude of each Zernike moment over that of order (0, 0).

        Source:
            Khotanzad and Hong 1990, eq. 7; on a grid of 32 x 32 with a basis computed once.
        """
        image = self._disc_image.ravel()
        # not `@`: a product this flat wakes all of BLAS's threads for nothing
        even, odd = np.einsum("kij,j->ki", _zernike_basis(), image)
        moments = np.hypot(even, odd) / max(float(image.sum()), 1e-9)
        return dict(zip(ZERNIKE_ORDERS, moments.tolist(), strict=True))

    @cached_property
    def contour_spectrum(self) -> FloatArray:
        """(64,) magnitudes of the contour's spectrum, sampled evenly along its length."""
        points = self.contour[:, 0] @ np.array([1, 1j])
        along = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(points, append=points[0])))])
        at = np.arange(_CONTOUR_SAMPLES) * (along[-1] / _CONTOUR_SAMPLES)
        samples = np.interp(at, along, np.append(points, points[0]))
        return np.abs(np.fft.fft(samples))

    @cached_property
    def lab(self) -> FloatArray:
        """(3,) CIELAB of the object's colour, L* from 0 to 100."""
        pixel = self.paint_bgr.astype(np.float32).reshape(1, 1, 3)
        return np.asarray(cv2.cvtColor(pixel, cv2.COLOR_BGR2LAB), np.float64).ravel()

    @cached_property
    def _box(self) -> tuple[ImageArray, ImageArray]:
        """Image and mask (0 or 1) of the object's box with a free pixel around it."""
        mask = self.mask.astype(np.uint8)
        x, y, width, height = cv2.boundingRect(mask)
        rows, cols = slice(y, y + height), slice(x, x + width)
        frame = (1, 1, 1, 1, cv2.BORDER_CONSTANT)
        image = cv2.copyMakeBorder(self.image_bgr[rows, cols], *frame, value=0)
        return np.asarray(image), np.asarray(cv2.copyMakeBorder(mask[rows, cols], *frame, value=0))


@cache
def _zernike_basis() -> NDArray[np.float32]:
    """Return real and imaginary parts of the basis, times n + 1, on a grid (2, orders, 32 * 32)."""
    axis = (np.arange(32) - 15.5) / 15.5
    x, y = np.meshgrid(axis, axis)
    rho, theta = np.hypot(x, y).ravel(), np.arctan2(y, x).ravel()
    rows = np.array(
        [
            np.where(rho <= 1, (n + 1) * _radial(n, m, rho) * np.exp(-1j * m * theta), 0)
            for n, m in ZERNIKE_ORDERS
        ]
    )
    return np.array([rows.real, rows.imag], np.float32)


def _radial(n: int, m: int, rho: FloatArray) -> FloatArray:
    """Return Zernike's radial polynomial."""
    radial = np.zeros_like(rho)
    for s in range((n - m) // 2 + 1):
        factor = (-1) ** s * factorial(n - s) / factorial(s)
        factor /= factorial((n + m) // 2 - s) * factorial((n - m) // 2 - s)
        radial += factor * rho ** (n - 2 * s)
    return radial
