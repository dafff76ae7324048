"""A fast turn is seen at a glance."""

import cv2
import numpy as np
import pytest

from gazemap.geometry.pose import Pose
from gazemap.slam.live.glance import turn_between
from tests.planes import CAMERA, draw, room, swaying


def turned(image, rotvec):
    H = CAMERA.K @ Pose.from_rotvec(rotvec, np.zeros(3)).R @ np.linalg.inv(CAMERA.K)
    size = (CAMERA.width_px, CAMERA.height_px)
    return cv2.warpPerspective(image, H, size, borderMode=cv2.BORDER_REFLECT)


@pytest.mark.parametrize("rotvec_deg", [[8, 0, 0], [-5, 12, 0], [0, -15, 2]])
def test_a_turn_of_many_degrees_is_found_within_two(rotvec_deg):
    image = draw(room(), swaying(1)[0])
    turn = turn_between(image, turned(image, np.radians(rotvec_deg)), CAMERA)
    off = turn.R @ Pose.from_rotvec(np.radians(rotvec_deg), np.zeros(3)).R.T
    assert np.degrees(np.arccos((np.trace(off) - 1) / 2)) < 2.5
