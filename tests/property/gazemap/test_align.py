import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gazemap.geometry.align import Similarity, fit_similarity
from gazemap.geometry.pose import Pose

seeds = st.integers(0, 2**32 - 1)


def random_similarity(rng):
    T = Pose.from_rotvec(rng.uniform(-2, 2, 3), rng.uniform(-5, 5, 3))
    return Similarity(scale=float(rng.uniform(0.1, 10)), R=T.R, t=T.t)


@given(seeds)
def test_the_inverse_takes_points_back(seed):
    rng = np.random.default_rng(seed)
    S = random_similarity(rng)
    points = rng.normal(size=(6, 3))
    assert np.allclose(S.inverse().transform(S.transform(points)), points, atol=1e-9)


@given(seeds)
def test_points_that_moved_give_their_similarity_back(seed):
    rng = np.random.default_rng(seed)
    S = random_similarity(rng)
    points = rng.normal(size=(8, 3))
    found = fit_similarity(points, S.transform(points))
    assert found is not None
    assert np.isclose(found.scale, S.scale, rtol=1e-9)
    assert np.allclose(found.transform(points), S.transform(points), atol=1e-8)


@given(seeds)
def test_poses_move_with_their_points(seed):
    rng = np.random.default_rng(seed)
    S = random_similarity(rng)
    T = Pose.from_rotvec(rng.uniform(-1, 1, 3), rng.normal(size=3))
    here = S.transform(T.transform(np.zeros(3)))
    assert np.allclose(S.transform_pose(T).t, here, atol=1e-9)


@given(seeds)
def test_points_on_a_line_fix_nothing(seed):
    rng = np.random.default_rng(seed)
    line = rng.normal(size=3)[None] * np.linspace(-1, 1, 7)[:, None]
    assert fit_similarity(line, random_similarity(rng).transform(line)) is None
