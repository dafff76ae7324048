from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gazemap.slam.live.bundle import BundleProblem, adjust_bundle

SIGMA = 0.0005
KEYFRAMES, POINTS = 8, 150


def scene(seed=0):
    """Return the truth as a problem with noisy measurements, poses and points exact."""
    rng = np.random.default_rng(seed)
    points = rng.uniform([-1, -1, -0.3], [1, 1, 0.3], (POINTS, 3))
    R = Rotation.from_rotvec(rng.normal(0, 0.15, (KEYFRAMES, 3))).as_matrix()
    t = np.array([0, 0, 3.0]) + rng.normal(0, 0.4, (KEYFRAMES, 3))
    point, keyframe = (a.ravel() for a in np.mgrid[:POINTS, :KEYFRAMES])
    seen = np.einsum("nij,nj->ni", R[keyframe], points[point]) + t[keyframe]
    xy = seen[:, :2] / seen[:, 2:] + rng.normal(0, SIGMA, (len(point), 2))
    return BundleProblem(
        R=R, t=t, twist=np.zeros((KEYFRAMES, 6)), keyframe_free=np.arange(KEYFRAMES) >= 2,
        points_world=points, point_free=np.ones(POINTS, bool), keyframe=keyframe, point=point,
        xy=xy, sigma=np.full(len(point), SIGMA), dt_s=np.zeros(len(point)),
    )  # fmt: skip


def shaken(truth, rng):
    free = truth.keyframe_free
    turn = Rotation.from_rotvec(rng.normal(0, 0.02, (KEYFRAMES, 3)) * free[:, None]).as_matrix()
    return replace(
        truth,
        R=turn @ truth.R,
        t=truth.t + rng.normal(0, 0.03, truth.t.shape) * free[:, None],
        points_world=truth.points_world + rng.normal(0, 0.03, truth.points_world.shape),
    )


def test_poses_and_points_come_back():
    truth = scene()
    fit = adjust_bundle(shaken(truth, np.random.default_rng(1)), rounds=20)
    assert 1e-5 < np.abs(fit.t - truth.t).max() < 6e-3
    assert np.median(np.linalg.norm(fit.points_world - truth.points_world, axis=1)) < 2e-3
    assert 0.8 < np.median(fit.error) < 1.3


def test_outliers_are_withstood_and_show():
    truth = scene()
    bad = np.random.default_rng(2).choice(len(truth.xy), 60, replace=False)
    xy = truth.xy.copy()
    xy[bad] += 0.05
    fit = adjust_bundle(shaken(replace(truth, xy=xy), np.random.default_rng(1)), rounds=20)
    assert np.abs(fit.t - truth.t).max() < 8e-3
    assert set(np.flatnonzero(fit.error > 20)) == set(bad)


def test_what_is_fixed_stays():
    truth = scene()
    problem = replace(shaken(truth, np.random.default_rng(1)), point_free=np.arange(POINTS) > 10)
    fit = adjust_bundle(problem)
    np.testing.assert_array_equal(fit.points_world[:11], problem.points_world[:11])
    np.testing.assert_array_equal(fit.t[:2], problem.t[:2])


def test_the_same_problem_gives_the_same_bits():
    problem = shaken(scene(), np.random.default_rng(1))
    first, second = adjust_bundle(problem), adjust_bundle(problem)
    np.testing.assert_array_equal(first.points_world, second.points_world)
    np.testing.assert_array_equal(first.R, second.R)


@pytest.mark.parametrize("readout", [0.0, 0.02])
def test_a_moving_shutter_is_modelled(readout):
    truth = scene()
    rng = np.random.default_rng(5)
    twist = rng.normal(0, 0.3, (KEYFRAMES, 6))
    dt_s = rng.uniform(-0.5, 0.5, len(truth.xy)) * readout
    seen = np.einsum("nij,nj->ni", truth.R[truth.keyframe], truth.points_world[truth.point])
    seen += truth.t[truth.keyframe]
    w = twist[truth.keyframe]
    seen += dt_s[:, None] * (np.cross(w[:, :3], seen) + w[:, 3:])
    xy = seen[:, :2] / seen[:, 2:] + rng.normal(0, SIGMA, truth.xy.shape)
    problem = replace(shaken(truth, rng), xy=xy, twist=twist, dt_s=dt_s)
    fit = adjust_bundle(problem, rounds=20)
    assert np.abs(fit.t - truth.t).max() < 6e-3
