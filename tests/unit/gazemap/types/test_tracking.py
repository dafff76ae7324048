import numpy as np
import pytest

from gazemap.errors import ConventionError
from gazemap.geometry.pose import Pose
from gazemap.types.tracking import Scale, Tracked, Trajectory

STEP_NS = 33_333_333


def path(times_ns):
    outcomes = [
        Tracked(
            t_ns=t, T_world_cam=Pose.from_rotvec([0, 0, t / STEP_NS * 0.1], [t / STEP_NS, 0, 1])
        )
        for t in times_ns
    ]
    return Trajectory.from_outcomes(outcomes, scale=Scale.METRIC)


def test_between_two_frames_position_and_rotation_are_interpolated():
    pose = path([0, STEP_NS]).at(STEP_NS // 2)
    np.testing.assert_allclose(pose.t, [0.5, 0, 1], atol=1e-7)
    np.testing.assert_allclose(pose.rotvec_rad, [0, 0, 0.05], atol=1e-7)


def test_at_a_frame_the_pose_is_that_frames():
    np.testing.assert_allclose(path([0, STEP_NS, 2 * STEP_NS]).at(STEP_NS).t, [1, 0, 1])


@pytest.mark.parametrize("t_ns", [-1, 10 * STEP_NS + 1])
def test_outside_the_path_there_is_no_pose(t_ns):
    assert path([0, 10 * STEP_NS]).at(t_ns, max_gap_ns=11 * STEP_NS) is None


def test_in_a_long_gap_there_is_no_pose():
    trajectory = path([0, STEP_NS, 8 * STEP_NS])
    assert trajectory.at(4 * STEP_NS) is None
    assert trajectory.at(4 * STEP_NS, max_gap_ns=8 * STEP_NS) is not None


def test_times_that_do_not_rise_are_refused():
    with pytest.raises(ConventionError, match="strictly increasing"):
        path([0, STEP_NS, STEP_NS])


def test_an_empty_path_knows_no_pose():
    empty = Trajectory.from_outcomes([], scale=Scale.ARBITRARY)
    assert len(empty) == 0
    assert empty.at(0) is None
