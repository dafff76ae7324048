"""Shadows on the table top: the outline of each convex body, along the light, onto z = 0."""

from collections.abc import Sequence

import cv2
import numpy as np

from gazemap.geometry.arrays import FloatArray, ImageArray
from gazemap.sim.surfaces import LIGHT_WORLD
from gazemap.sim.tabletop import TABLE_SIZE_M

_PX_PER_M = 500.0
_SHADE = 255 - 105  # light that is left in full shadow, of 255
_SOFT_SIGMA_PX = 1.2
_FRACTION_BITS = 4


class ShadowPainter:
    """Paints the light on the table top; the shadows of what stands still are painted once."""

    def __init__(self, still: Sequence[FloatArray]) -> None:
        """Paint the shadows of static bodies, each given by corners (_, 3) in world."""
        width, height = (round(side * _PX_PER_M) for side in TABLE_SIZE_M)
        self._still = np.full((height, width), 255, np.uint8)
        for corners in still:
            _paint(self._still, corners)

    def paint(self, moving: Sequence[FloatArray]) -> ImageArray:
        """Return the light (h, w), 255 fully lit, with bodies of corners (_, 3) added."""
        light = self._still.copy()
        for corners in moving:
            _paint(light, corners)
        return np.asarray(cv2.GaussianBlur(light, (0, 0), _SOFT_SIGMA_PX))


def on_table(points_world: FloatArray) -> FloatArray:
    """Return where the shadows of points (N, 3) fall on the plane of the table top, (N, 3)."""
    shadow: FloatArray = points_world - points_world[:, 2:] / LIGHT_WORLD[2] * LIGHT_WORLD
    return shadow


def _paint(light: ImageArray, corners_world: FloatArray) -> None:
    ground = on_table(corners_world)[:, :2]
    uv = ground * [_PX_PER_M, -_PX_PER_M] + [light.shape[1] / 2, light.shape[0] / 2] - 0.5
    hull = cv2.convexHull(np.round(uv * 2**_FRACTION_BITS).astype(np.int32))
    cv2.fillConvexPoly(light, hull, _SHADE, cv2.LINE_AA, _FRACTION_BITS)
