import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gazemap.geometry.pose import Pose
from gazemap.slam.live.refine import PoseProblem, refine_pose

SIGMA = 0.001


def problem_of(T_cam_world, *, seed=0, outlier_count=0, count=120, twist=None, dt_s=None):
    rng = np.random.default_rng(seed)
    points_cam = rng.uniform([-1, -1, 1.5], [1, 1, 4], (count, 3))
    points_world = T_cam_world.inverse().transform(points_cam)
    twist = np.zeros(6) if twist is None else twist
    dt_s = np.zeros(count) if dt_s is None else dt_s
    moving = points_cam + dt_s[:, None] * (np.cross(twist[:3], points_cam) + twist[3:])
    xy = moving[:, :2] / moving[:, 2:] + rng.normal(0, SIGMA, (count, 2))
    xy[:outlier_count] += rng.uniform(0.05, 0.3, (outlier_count, 2))
    return PoseProblem(
        points_world=points_world, xy=xy, sigma=np.full(count, SIGMA), dt_s=dt_s, twist=twist
    )


TRUE = Pose.from_rotvec([0.3, -0.2, 0.1], [0.2, 0.5, 1.0])
START = Pose.from_rotvec([0.35, -0.17, 0.07], [0.25, 0.43, 1.1])


def off(pose):
    turn = np.linalg.norm(Rotation.from_matrix(pose.R @ TRUE.R.T).as_rotvec())
    return turn, np.linalg.norm(pose.inverse().t - TRUE.inverse().t)


@pytest.mark.parametrize("outlier_count", [0, 40])
def test_the_pose_is_found_among_outliers(outlier_count):
    fit = refine_pose(START, problem_of(TRUE, outlier_count=outlier_count))
    turn, shift = off(fit.T_cam_world)
    assert 1e-6 < turn < 1e-3
    assert shift < 2.5e-3
    assert (~fit.inliers(5.0)).sum() == outlier_count


def test_the_covariance_is_that_of_many_runs():
    fits = [refine_pose(START, problem_of(TRUE, seed=s)) for s in range(150)]
    tangents = []
    for fit in fits:
        turn = Rotation.from_matrix(TRUE.R @ fit.T_cam_world.R.T)
        tangents.append([*turn.as_rotvec(), *(TRUE.t - turn.as_matrix() @ fit.T_cam_world.t)])
    told = np.mean([np.sqrt(np.diag(fit.cov_cam)) for fit in fits], axis=0)
    ratio = np.std(tangents, axis=0) / told
    assert (ratio > 0.6).all()
    assert (ratio < 1.6).all()


def test_a_rolling_shutter_is_taken_out():
    twist = np.array([0.4, -0.3, 0.5, 0.2, 0.3, -0.1])
    dt_s = np.linspace(-0.01, 0.01, 120)
    problem = problem_of(TRUE, twist=twist, dt_s=dt_s)
    turn, shift = off(refine_pose(START, problem).T_cam_world)
    assert turn < 1e-3
    assert shift < 2.5e-3


def test_too_few_points_and_a_singular_system_are_no_pose():
    assert refine_pose(START, problem_of(TRUE, count=3)) is None
    behind = problem_of(TRUE)
    turned = Pose(R=np.diag([1.0, -1.0, -1.0]) @ TRUE.R, t=-5 * np.ones(3))
    fit = refine_pose(turned, behind)
    assert fit is None or not fit.inliers(3.0).any()
