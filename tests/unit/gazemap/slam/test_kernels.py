"""Compiled kernels: the pose of one frame, and patches found again."""

import numpy as np
import pytest

from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Pose
from gazemap.slam.config import PatchConfig
from gazemap.slam.frame_path import FramePath, shutter_shift
from gazemap.slam.framewise import FrameViews
from gazemap.slam.patches import PatchAtlas
from gazemap.slam.pose_solver import fit_pose
from gazemap.slam.rolling_shutter import estimate_readout, pose_slopes
from gazemap.slam.structure import intersect_rays
from tests import planes

FOCAL_PX = 500.0


@pytest.fixture
def rng():
    return np.random.default_rng(11)


def seen(T_cam_map, points):
    in_cam = T_cam_map.transform(points)
    return in_cam[:, :2] / in_cam[:, 2:]


def test_a_pose_survives_noise_and_a_fifth_of_outliers(rng):
    points = rng.uniform([-1, -1, 2], [1, 1, 4], (200, 3))
    T = Pose.from_rotvec([0.1, -0.2, 0.05], [0.2, 0.1, -0.1])
    flat = seen(T, points) + rng.normal(0, 0.3 / FOCAL_PX, (200, 2))
    flat[:40] += rng.uniform(-0.2, 0.2, (40, 2))
    fit = fit_pose(
        np.eye(3), np.zeros(3), points_map=points, flat=flat, cauchy=0.5 / FOCAL_PX, steps=25
    )
    off = np.linalg.norm(fit.t_cam_map - T.t)
    assert 1e-6 < off < 2e-3
    assert fit.inliers(2 / FOCAL_PX)[40:].mean() > 0.97
    assert fit.inliers(2 / FOCAL_PX)[:40].mean() < 0.2


def test_the_slopes_of_a_pose_are_those_of_its_views(rng):
    in_cam = rng.uniform([-1, -1, 2], [1, 1, 4], (5, 3))
    tangent = rng.normal(0, 1e-6, 6)
    moved = Pose.from_rotvec(tangent[:3], tangent[3:]).transform(in_cam)
    change = (moved[:, :2] / moved[:, 2:] - in_cam[:, :2] / in_cam[:, 2:]).ravel()
    assert np.allclose(pose_slopes(in_cam) @ tangent, change, atol=1e-10)


def test_rays_meet_at_their_point_and_parallax_is_their_angle():
    centres = np.array([[0.0, 0, 0], [1.0, 0, 0]])
    point = np.array([0.5, 0.0, 2.0])
    flat = (point - centres)[:, :2] / 2.0
    found, parallax = intersect_rays(
        np.tile(np.eye(3), (2, 1, 1)), -centres, flat, group=np.array([1, 1]), group_count=2
    )
    assert np.allclose(found[1], point)
    assert np.isnan(found[0]).all()
    assert parallax[1] == pytest.approx(2 * np.arctan(0.25))


@pytest.fixture(scope="module")
def two_views():
    first, second = planes.swaying(13)[0], planes.swaying(13)[12]
    room = planes.room()
    v, u = np.mgrid[150:270:30, 120:300:30]
    uv = np.column_stack([u.ravel(), v.ravel()]).astype(float)
    rays = first.rotate(planes.CAMERA.unproject(uv))
    points = first.t - rays * (first.t[2] / rays[:, 2])[:, None]
    images = [planes.draw(room, first), planes.draw(room, second)]
    return images, [first.inverse(), second.inverse()], uv, points


def atlas_of(two_views):
    images, (T, _), uv, points = two_views
    atlas = PatchAtlas(planes.CAMERA, uv_px=uv, config=PatchConfig())
    atlas.take_references(images[0], np.arange(len(uv)))
    atlas.place(points, np.tile(T.R, (len(uv), 1, 1)), np.tile(T.t, (len(uv), 1)))
    return atlas


def test_patches_are_found_again_far_below_a_pixel(two_views):
    images, (_, T), _, points = two_views
    nearly = Pose.from_rotvec([0.004, -0.003, 0.0], [0, 0, 0]) @ T  # some two pixels off
    views = atlas_of(two_views).find(images[1], nearly.R, nearly.t)
    true = planes.CAMERA.project(T.transform(points))[views.point]
    off = np.linalg.norm(views.uv_px - true, axis=1)
    assert len(views.point) > 0.5 * len(points)
    assert 1e-4 < np.median(off) < 0.15


def test_gain_and_offset_move_no_patch(two_views):
    images, (_, T), _, _ = two_views
    atlas = atlas_of(two_views)
    before = atlas.find(images[1], T.R, T.t)
    darker = np.round(images[1] * 0.6 + 20).astype(np.uint8)
    after = atlas.find(darker, T.R, T.t)
    both, i, j = np.intersect1d(before.point, after.point, return_indices=True)
    assert len(both) > 0.5 * len(before.point)
    assert np.median(np.abs(before.uv_px[i] - after.uv_px[j])) < 0.02


def test_what_is_covered_is_not_found(two_views):
    images, (_, T), _, _ = two_views
    covered = images[1].copy()
    covered[100:] = np.random.default_rng(0).integers(0, 255, covered[100:].shape)
    assert len(atlas_of(two_views).find(covered, T.R, T.t).point) == 0


def test_the_read_out_time_is_estimated_from_what_is_left(rng):
    camera = Camera(
        width_px=640, height_px=480, K=[[500, 0, 320], [0, 500, 240], [0, 0, 1]], distortion=[]
    )
    count, readout_s = 40, 0.02
    t_ns = np.arange(count) * 33_333_333
    path = FramePath.unposed(t_ns)
    path.is_posed[:] = True
    s = t_ns / 1e9
    for i in range(count):
        T = Pose.from_rotvec([0.2 * np.sin(5 * s[i]), 0.3 * np.sin(3 * s[i]), 0], [0, 0, 0])
        path.R_cam_map[i], path.t_cam_map[i] = T.R, T.t
    points = rng.uniform([-1, -1, 2], [1, 1, 4], (150, 3))
    views, rows = [], []
    for i, twist in enumerate(path.twists()):
        in_cam = points @ path.R_cam_map[i].T + path.t_cam_map[i]
        v_px = 500 * in_cam[:, 1] / in_cam[:, 2] + 240
        delay_s = camera.with_readout(readout_s).row_delay_ns(v_px) / 1e9
        shift = shutter_shift(in_cam, twist=twist, delay_s=delay_s)
        noise = rng.normal(0, 0.2 / 500, (150, 2))
        flat = in_cam[:, :2] / in_cam[:, 2:] + shift + noise
        views.append(FrameViews(point=np.arange(150), flat=flat))
        rows.append(v_px)
    estimate = estimate_readout(
        views, rows, path=path, points_map=points, camera=camera, cauchy=10 / 500
    )
    assert estimate.is_significant
    assert 1e-7 < abs(estimate.extra_s - readout_s) < 5 * estimate.sigma_s + 2e-4
