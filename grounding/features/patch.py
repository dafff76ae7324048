"""A patch with its object's mask, and the measurements that several features share."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from grounding.features.background import Mask
from grounding.types import FloatArray, ImageArray


@dataclass(frozen=True, kw_only=True, eq=False)
class MaskedPatch:
    """What a feature is a function of; measurements are made once, when first asked for.

    Attributes:
        image_bgr: (H, W, 3).
        mask: (H, W) the object.
        mm_per_px: the metric scale in the object's plane, or None.
        height_mm: the object's height where the scene gives it, or None.
        white_bgr: how a white surface looks under this light, or None to trust the camera.
    """

    image_bgr: ImageArray
    mask: Mask
    mm_per_px: float | None = None
    height_mm: float | None = None
    white_bgr: tuple[float, float, float] | None = None

    @cached_property
    def paint_bgr(self) -> FloatArray:
        """(3,) the object's colour in [0, 1] after white balance.

        The median of the brighter half of its inside: sides in shade and highlights stay out.
        """
        image, mask = self._box
        inside = cv2.erode(mask, np.ones((3, 3), np.uint8)) > 0
        pixels = image[inside if np.count_nonzero(inside) >= 9 else mask > 0].astype(np.float32)
        brightness = pixels.sum(axis=1)
        half, top = np.partition(brightness, (len(pixels) // 2, -1 - len(pixels) // 50))[
            [len(pixels) // 2, -1 - len(pixels) // 50]
        ]
        lit = pixels[(brightness >= half) & (brightness <= top)]
        white = np.asarray(self.white_bgr or (255.0, 255.0, 255.0))
        colour: FloatArray = np.median(lit, axis=0) / np.maximum(white, 1.0)
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
    def disc_image(self) -> FloatArray:
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
        return np.asarray(shrunk, np.float64) / 255

    @cached_property
    def _box(self) -> tuple[ImageArray, ImageArray]:
        """Image and mask (0 or 1) of the object's box with a free pixel around it."""
        mask = self.mask.astype(np.uint8)
        x, y, width, height = cv2.boundingRect(mask)
        rows, cols = slice(y, y + height), slice(x, x + width)
        frame = (1, 1, 1, 1, cv2.BORDER_CONSTANT)
        image = cv2.copyMakeBorder(self.image_bgr[rows, cols], *frame, value=0)
        return np.asarray(image), np.asarray(cv2.copyMakeBorder(mask[rows, cols], *frame, value=0))
