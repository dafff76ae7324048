"""Projection and its inverse cancel, whatever the lens."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gazemap.geometry.camera import Camera, LensModel

LENSES = {
    "ideal": (LensModel.PINHOLE, []),
    "four": (LensModel.PINHOLE, [-0.12, 0.05, 0.001, -0.0005]),
    "five": (LensModel.PINHOLE, [-0.28, 0.09, 0.0004, -0.0002, -0.01]),
    "eight": (LensModel.PINHOLE, [-0.128, 0.107, 0.0003, -0.0006, 0.0003, 0.17, 0.053, 0.024]),
    "twelve": (LensModel.PINHOLE, [-0.1, 0.05, 0, 0, 0, 0.1, 0.02, 0, 1e-3, -1e-4, 5e-4, 1e-4]),
    "fourteen": (LensModel.PINHOLE, [-0.1, 0.05, 0, 0, 0, 0.1, 0.02, 0, 0, 0, 0, 0, 0.01, -0.02]),
    "fisheye": (LensModel.FISHEYE, [0.04, -0.01, 0.004, -0.001]),
}


def camera_of(name, focal=500.0):
    lens, distortion = LENSES[name]
    K = [[focal, 0, 401.3], [0, focal * 0.99, 297.8], [0, 0, 1]]
    return Camera(width_px=800, height_px=600, K=K, distortion=distortion, lens=lens)


# Shorter ones would bend the corners of the image back: the lens has no inverse there.
cameras = st.builds(camera_of, st.sampled_from(sorted(LENSES)), st.floats(540, 900))
pixels = st.integers(0, 2**31).map(
    lambda seed: np.random.default_rng(seed).uniform((0, 0), (799, 599), (20, 2))
)
depths = st.floats(0.05, 50)


@given(cameras, pixels, depths)
def test_a_pixel_comes_back_from_its_ray_at_any_depth(camera, uv_px, depth):
    again = camera.project(camera.unproject(uv_px) * depth)
    np.testing.assert_allclose(again, uv_px, atol=1e-5)


@given(cameras, pixels)
def test_rays_are_unit_and_point_forward(camera, uv_px):
    rays = camera.unproject(uv_px)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=1), 1.0, atol=1e-12)
    assert (rays[:, 2] > 0).all()


@given(cameras, pixels)
def test_flat_coordinates_and_rays_agree(camera, uv_px):
    rays = camera.unproject(uv_px)
    np.testing.assert_allclose(rays[:, :2] / rays[:, 2:], camera.normalize(uv_px), atol=1e-12)


@given(cameras, pixels)
def test_what_lies_behind_has_no_pixel(camera, uv_px):
    assert np.isnan(camera.project(-camera.unproject(uv_px))).all()


@given(cameras)
def test_the_axis_meets_the_principal_point(camera):
    centre = camera.project(np.array([[0.0, 0.0, 2.0]]))
    np.testing.assert_allclose(centre, [[401.3, 297.8]], atol=1e-9)


@given(pixels)
def test_no_pixels_and_one_are_no_special_cases(uv_px):
    camera = camera_of("eight")
    assert camera.normalize(np.empty((0, 2))).shape == (0, 2)
    assert camera.project(np.empty((0, 3))).shape == (0, 2)
    np.testing.assert_allclose(camera.normalize(uv_px[:1]), camera.normalize(uv_px)[:1])


@given(st.floats(0, 0.03))
def test_the_middle_row_is_exposed_at_the_frame_time(readout_s):
    camera = camera_of("ideal").with_readout(readout_s)
    delay_ns = camera.row_delay_ns(np.array([0.0, 299.5, 599.0]))
    np.testing.assert_allclose(delay_ns, np.array([-0.5, 0.0, 0.5]) * readout_s * 1e9, atol=1e-3)
