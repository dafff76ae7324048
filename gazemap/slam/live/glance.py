"""How far the view as a whole has turned: for turns too fast for the flow of single points."""

import cv2
import numpy as np

from gazemap.geometry.arrays import ImageArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose

_WIDTH = 96


def turn_between(before: ImageArray, after: ImageArray, camera: Camera) -> Pose[Cam, Cam]:
    """Return the turn `T_after_before` of the camera that shifts one image best to the next.

    Both are compared as thumbnails. It is a guess: images without anything in common give some too.

    Args:
        before: (height, width).
        after: (height, width).
        camera: the head camera; only its focal length is used.

    Source:
        Klein and Murray 2008, sec. 3.4, with phase correlation for the shift.
    """
    scale = before.shape[1] / _WIDTH
    size = (_WIDTH, round(before.shape[0] / scale))
    small, small_after = (
        cv2.resize(image, size, interpolation=cv2.INTER_AREA).astype(np.float32)
        for image in (before, after)
    )
    window = cv2.createHanningWindow(size, cv2.CV_32F)
    shift, _ = cv2.phaseCorrelate(small, small_after, window)
    x, y = np.array(shift) * scale / np.diag(camera.K)[:2]
    return Pose.from_rotvec([-np.arctan(y), np.arctan(x), 0.0], np.zeros(3))
