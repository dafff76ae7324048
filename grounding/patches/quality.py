"""Whether a patch shows its thing: uncovered, sharp, and not the bare table."""

from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np

from grounding.features.background import NoObject, segment_object
from grounding.types import ImageArray

_CHANGED_LEVELS: Final = 30.0  # a pixel that differs by more shows something else
_CHANGED_SHARE: Final = 0.06
_CHANGED_SHARE_MOVING: Final = 0.15  # what is not level shifts where the camera moves
_SHARPNESS: Final = 0.35  # of the sharpest of the same showing


def still_picture(images: Sequence[ImageArray]) -> ImageArray | None:
    """Return the median of pictures of one place: a hand that passes is not in it."""
    if not images:
        return None
    return np.asarray(np.median(np.stack(images), axis=0), dtype=np.uint8)


def is_covered(image_bgr: ImageArray, still_bgr: ImageArray, *, is_fixed: bool) -> bool:
    """Return whether something stands before the thing that mostly is not there.

    Brightness is matched first, channel by channel: a light that changes covers nothing.
    """
    image, still = image_bgr.astype(np.float32), still_bgr.astype(np.float32)
    gain = np.median((still + 8.0) / (image + 8.0), axis=(0, 1))
    off = np.abs((image + 8.0) * gain - (still + 8.0)).max(axis=2)
    # A median filter takes out edges that a shake of one pixel moves.
    changed = cv2.medianBlur((off > _CHANGED_LEVELS).astype(np.uint8), 3)
    return float(changed.mean()) > (_CHANGED_SHARE if is_fixed else _CHANGED_SHARE_MOVING)


def is_blurred(image_bgr: ImageArray, others: Sequence[ImageArray]) -> bool:
    """Return whether a picture is much less sharp than the sharper ones of the same thing."""
    if len(others) < 3:
        return False
    best = float(np.quantile([sharpness(each) for each in others], 0.75))
    return sharpness(image_bgr) < _SHARPNESS * best


def sharpness(image_bgr: ImageArray) -> float:
    """Return the variance of the Laplacian over that of the grey levels."""
    grey = cv2.cvtColor(image_bgr, cv2.COLOR_BGR2GRAY).astype(np.float32)
    return float(cv2.Laplacian(grey, cv2.CV_32F).var() / (grey.var() + 1.0))


def shows_object(image_bgr: ImageArray) -> bool:
    """Return whether there is a thing in the middle, apart from the table."""
    return not isinstance(segment_object(image_bgr), NoObject)
