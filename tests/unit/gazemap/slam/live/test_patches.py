import cv2
import numpy as np
import pytest

from gazemap.slam.live.patches import Pyramid, align_patches, cut_patches
from tests.planes import textured

IMAGE = textured(3)
UV = np.array([[100.0, 120.0], [200.0, 90.0], [250.0, 300.0], [60.0, 340.0]])


def warped(matrix):
    """Return the image seen through x_new = matrix @ [x, y, 1]."""
    return cv2.warpAffine(IMAGE, matrix, IMAGE.shape[::-1], flags=cv2.INTER_LINEAR)


@pytest.mark.parametrize("shift", [(0.3, -0.4), (1.7, 0.9), (-2.2, 1.3)])
def test_a_shift_is_found_to_a_few_hundredths_of_a_pixel(shift):
    moved = Pyramid.of(warped(np.array([[1, 0, shift[0]], [0, 1, shift[1]]])))
    references = cut_patches(Pyramid.of(IMAGE), UV)
    found, correlation = align_patches(moved, references, np.tile(np.eye(2), (4, 1, 1)), UV)
    assert (correlation > 0.95).all()
    assert np.abs(found - UV - shift).max() < 0.08


def test_gain_and_offset_do_no_harm():
    darker = Pyramid.of((0.6 * warped(np.array([[1, 0, 0.5], [0, 1, 0.25]])) + 30).astype(np.uint8))
    references = cut_patches(Pyramid.of(IMAGE), UV)
    found, correlation = align_patches(darker, references, np.tile(np.eye(2), (4, 1, 1)), UV)
    assert (correlation > 0.95).all()
    assert np.abs(found - UV - (0.5, 0.25)).max() < 0.08


def test_a_turned_and_grown_patch_is_found_through_its_warp():
    a, grow = np.radians(25), 1.25
    turn = grow * np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    centre = np.array([200.0, 200.0])
    shift = centre - turn @ centre
    seen = Pyramid.of(warped(np.column_stack([turn, shift])))
    uv = np.array([[210.0, 180.0], [180.0, 230.0]])
    references = cut_patches(Pyramid.of(IMAGE), uv)
    truth = uv @ turn.T + shift
    from_image = np.tile(np.linalg.inv(turn), (2, 1, 1))
    found, correlation = align_patches(seen, references, from_image, truth + np.array([1.1, -0.8]))
    assert (correlation > 0.9).all()
    assert np.abs(found - truth).max() < 0.15


def test_the_coarse_level_doubles_the_reach():
    moved = Pyramid.of(warped(np.array([[1, 0, 6.0], [0, 1, -5.0]])))
    references = cut_patches(Pyramid.of(IMAGE), UV)
    found, correlation = align_patches(
        moved, references, np.tile(np.eye(2), (4, 1, 1)), UV, coarse=True
    )
    good = correlation > 0.9
    assert good.sum() >= 3
    assert np.abs(found[good] - UV[good] - (6, -5)).max() < 0.1


def test_another_texture_does_not_pass():
    other = Pyramid.of(textured(4))
    references = cut_patches(Pyramid.of(IMAGE), UV)
    _, correlation = align_patches(other, references, np.tile(np.eye(2), (4, 1, 1)), UV)
    assert (correlation < 0.8).all()


def test_a_flat_image_and_the_border_fail_as_values():
    flat = Pyramid.of(np.full_like(IMAGE, 90))
    references = cut_patches(Pyramid.of(IMAGE), UV)
    _, correlation = align_patches(flat, references, np.tile(np.eye(2), (4, 1, 1)), UV)
    assert (correlation == -1).all()
    corner = np.array([[2.0, 2.0]])
    _, correlation = align_patches(
        Pyramid.of(IMAGE), cut_patches(Pyramid.of(IMAGE), corner), np.eye(2)[None], corner
    )
    assert correlation[0] == -1
