"""Shape features, all free of position, rotation and scale."""

import math
from typing import Final

import cv2

from grounding.features.patch import MaskedPatch

FOURIER_ORDERS: Final = (-1, 2, -2, 3, -3)


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
    """Return the magnitude of a Zernike moment over that of order (0, 0)."""
    return patch.zernike[order]


def fourier(patch: MaskedPatch, *, order: int) -> float:
    """Return the magnitude of a Fourier descriptor of the outer contour over that of order 1."""
    spectrum = patch.contour_spectrum
    scale = max(spectrum[1], spectrum[-1])
    other = min(spectrum[1], spectrum[-1]) if order == -1 else spectrum[order]
    return float(other / max(scale, 1e-9))
