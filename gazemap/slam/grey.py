"""Images as the trackers want them: one channel of brightness."""

import cv2
import numpy as np

from gazemap.geometry.arrays import ImageArray


def to_grey(image: ImageArray) -> ImageArray:
    """Return (height, width) brightness of a grey (height, width) or BGR (height, width, 3) image.

    The array is contiguous; a grey one is not copied where it already is.
    """
    shape: tuple[int, ...] = image.shape
    if len(shape) == 2:
        return np.ascontiguousarray(image)
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
