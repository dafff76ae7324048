import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gazemap.geometry.align import Similarity
from gazemap.geometry.pose import Pose
from gazemap.slam.live.pose_graph import LoopEdge, close_loops


def circle(count):
    return {
        k: Pose.from_rotvec(
            [0, 0, 2 * np.pi * k / count], [np.cos(a), np.sin(a), 0.1 * np.sin(3 * a)]
        )
        for k, a in enumerate(2 * np.pi * np.arange(count) / count)
    }


def drifted(true, *, scale_step, turn_step):
    """Chain the true steps, each grown and turned a little against the last."""
    poses, growth = {0: true[0]}, 1.0
    for k in range(1, len(true)):
        step = true[k - 1].inverse() @ true[k]
        growth *= scale_step
        turn = Rotation.from_rotvec([0, 0, turn_step]).as_matrix()
        poses[k] = poses[k - 1] @ Pose(R=turn @ step.R, t=growth * step.t)
    return poses, growth


@pytest.mark.parametrize(("scale_step", "metric"), [(1.005, False), (1.0, True)])
def test_a_loop_takes_the_drift_out(scale_step, metric):
    true = circle(40)
    poses, growth = drifted(true, scale_step=scale_step, turn_step=0.004)
    last = true[0].inverse() @ true[39]
    loop = LoopEdge(here=0, there=39, S_here_there=Similarity(scale=1 / growth, R=last.R, t=last.t))
    edges = [(k, k + 1) for k in range(39)]
    solved = close_loops(poses, edges, [loop], depth=1.0, metric=metric)
    before = max(np.linalg.norm(poses[k].t - true[k].t) for k in true)
    after = max(np.linalg.norm(solved[k].t - true[k].t) for k in true)
    assert before > 0.1
    assert after < 0.35 * before
    np.testing.assert_allclose(solved[0].t, true[0].t, atol=1e-3)
    if metric:
        assert all(abs(S.scale - 1) < 1e-3 for S in solved.values())
    else:
        assert solved[39].scale == pytest.approx(1 / growth, rel=0.03)


def test_without_drift_nothing_moves():
    true = circle(12)
    relative = true[0].inverse() @ true[11]
    loop = LoopEdge(
        here=0, there=11, S_here_there=Similarity(scale=1.0, R=relative.R, t=relative.t)
    )
    solved = close_loops(true, [(k, k + 1) for k in range(11)], [loop], depth=1.0, metric=False)
    for k, S in solved.items():
        np.testing.assert_allclose(S.t, true[k].t, atol=1e-6)
        assert S.scale == pytest.approx(1.0, abs=1e-6)
