"""Shape features, all free of position, rotation and scale."""

import functools
import math
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from grounding.features.patch import MaskedPatch
from grounding.types import FloatArray

ZERNIKE_ORDERS: Final = tuple((n, m) for n in range(2, 7) for m in range(n + 1) if (n - m) % 2 == 0)
FOURIER_ORDERS: Final = (-1, 2, -2, 3, -3)
_CONTOUR_SAMPLES: Final = 64


def solidity(patch: MaskedPatch) -> float:
    """Return the area over that of the convex hull."""
    hull = cv2.convexHull(patch.contour)
    hull_area = cv2.contourArea(hull) + cv2.arcLength(hull, closed=True) / 2 + 1
    return patch.area_px / hull_area


def circularity(patch: MaskedPatch) -> float:
    """Return 4 pi area over the squared perimeter of the hull: 1 for a disc, 0.785 for a square.

    The hull's perimeter, since that of a pixel contour depends on how it lies on the grid.
    """
    perimeter = cv2.arcLength(cv2.convexHull(patch.contour), closed=True) + 4
    return 4 * math.pi * patch.outline_area_px / perimeter**2


def rectangularity(patch: MaskedPatch) -> float:
    """Return the area over that of the tightest rectangle."""
    length, width = patch.sides_px
    return patch.area_px / (length * width)


def elongation(patch: MaskedPatch) -> float:
    """Return ln of length over width of the tightest rectangle: 0 for a square."""
    length, width = patch.sides_px
    return math.log(length / width)


def hole(patch: MaskedPatch) -> float:
    """Return the share of the outline that is holes."""
    return max(0.0, 1 - patch.area_px / patch.outline_area_px)


def hu(patch: MaskedPatch, *, order: int) -> float:
    """Return the signed square root of a moment of Hu, which brings the orders to one range."""
    value = float(patch.hu[order])
    return math.copysign(math.sqrt(abs(value)), value)


def zernike(patch: MaskedPatch, *, order: tuple[int, int]) -> float:
    """Return the magnitude of a Zernike moment over that of order (0, 0).

    Source:
        Khotanzad and Hong 1990, eq. 7; on a grid of 32 x 32 with a basis computed once.
    """
    image = patch.disc_image.ravel()
    moment = abs(_zernike_basis(*order) @ image)
    return float(moment / max(image.sum(), 1e-9))


def fourier(patch: MaskedPatch, *, order: int) -> float:
    """Return the magnitude of a Fourier descriptor of the outer contour over that of order 1."""
    spectrum = _contour_spectrum(patch)
    scale = max(spectrum[1], spectrum[-1])
    other = min(spectrum[1], spectrum[-1]) if order == -1 else spectrum[order]
    return float(other / max(scale, 1e-9))


@functools.cache
def _zernike_basis(n: int, m: int) -> NDArray[np.complex128]:
    """Return the conjugate basis function times (n + 1) over a grid of (32 * 32,), 0 off disc."""
    axis = (np.arange(32) - 15.5) / 15.5
    x, y = np.meshgrid(axis, axis)
    rho, theta = np.hypot(x, y), np.arctan2(y, x)
    radial = np.zeros_like(rho)
    for s in range((n - m) // 2 + 1):
        factor = (-1) ** s * math.factorial(n - s) / math.factorial(s)
        factor /= math.factorial((n + m) // 2 - s) * math.factorial((n - m) // 2 - s)
        radial += factor * rho ** (n - 2 * s)
    basis: NDArray[np.complex128] = (n + 1) * radial * np.exp(-1j * m * theta)
    return np.where(rho <= 1, basis, 0).ravel()


def _contour_spectrum(patch: MaskedPatch) -> FloatArray:
    """Return the magnitudes (64,) of the contour's spectrum, sampled evenly along its length."""
    points = patch.contour[:, 0].astype(np.float64)
    closed = np.vstack([points, points[:1]])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    at = np.arange(_CONTOUR_SAMPLES) * (along[-1] / _CONTOUR_SAMPLES)
    samples = np.interp(at, along, closed[:, 0]) + 1j * np.interp(at, along, closed[:, 1])
    return np.abs(np.fft.fft(samples))
