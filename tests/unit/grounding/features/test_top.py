import cv2
import numpy as np
import pytest

from grounding.features.top import grown_top

TABLE_BGR = (90, 110, 130)
TABLE = [(np.array(TABLE_BGR, np.float32), 0.9, 1.1)]


def patch(colour: tuple[int, int, int], *, noise: float, shadow: bool = False) -> np.ndarray:
    """Return a square of 40 pixels on a table."""
    image = np.full((128, 128, 3), TABLE_BGR, np.uint8)
    if shadow:
        image[50:92, 50:92] = np.array(TABLE_BGR) // 2
    image[44:84, 44:84] = colour
    noisy = cv2.GaussianBlur(image, (0, 0), 0.7) + np.random.default_rng(0).normal(
        0, noise, image.shape
    )
    return cv2.GaussianBlur(np.clip(noisy, 0, 255).astype(np.uint8), (3, 3), 0)


@pytest.mark.parametrize("colour", [(30, 30, 30), (225, 225, 225), (60, 150, 60), (40, 40, 200)])
@pytest.mark.parametrize("noise", [1.0, 6.0])
def test_a_square_is_about_as_large_as_it_is(colour: tuple[int, int, int], noise: float):
    top = grown_top(patch(colour, noise=noise), TABLE)
    assert top is not None
    assert 0.88 * 1600 < np.count_nonzero(top) < 1.06 * 1600


def test_the_shadow_of_a_black_thing_is_left_out():
    top = grown_top(patch((25, 25, 25), noise=2.0, shadow=True), TABLE)
    assert top is not None
    assert 0.94 * 1600 < np.count_nonzero(top) < 1.08 * 1600


def test_the_bare_table_has_no_top():
    assert grown_top(patch(TABLE_BGR, noise=2.0), TABLE) is None
