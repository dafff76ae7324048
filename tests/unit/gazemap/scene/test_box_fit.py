import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gazemap.scene.box_fit import Box

SIDES_M = st.tuples(*[st.floats(0.02, 0.2)] * 3)


def inside(box: Box, points: np.ndarray) -> np.ndarray:
    c, s = np.cos(box.yaw_rad), np.sin(box.yaw_rad)
    local = (points - box.centre) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return np.asarray((np.abs(local) <= box.size_m / 2).all(axis=1))


@given(SIDES_M, SIDES_M, st.tuples(*[st.floats(-0.1, 0.1)] * 3), st.floats(-3.0, 3.0))
def test_the_room_that_two_boxes_share_is_that_of_their_common_points(one, two, apart, yaw_rad):
    a = Box(centre=np.zeros(3), yaw_rad=0.3, size_m=np.array(one))
    b = Box(centre=np.array(apart), yaw_rad=yaw_rad, size_m=np.array(two))
    points = np.random.default_rng(0).uniform(-0.2, 0.2, (40_000, 3))
    expected = 0.4**3 * (inside(a, points) & inside(b, points)).mean()
    assert abs(a.shared_m3(b) - expected) < 4 * 0.4**3 * np.sqrt(expected / 0.4**3 / 40_000) + 1e-5
    assert abs(a.shared_m3(b) - b.shared_m3(a)) < 1e-9
