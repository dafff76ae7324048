"""Poses form a group, and every way of writing one down leads back to it."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gazemap.geometry.align import Similarity, fit_similarity, fit_similarity_of_poses
from gazemap.geometry.pose import Pose

numbers = st.floats(-3, 3, allow_subnormal=False)
vectors = st.tuples(numbers, numbers, numbers).map(np.array)
poses = st.builds(Pose.from_rotvec, vectors, vectors)
clouds = st.integers(0, 2**31).map(lambda seed: np.random.default_rng(seed).normal(size=(12, 3)))
similarities = st.builds(
    lambda pose, scale: Similarity(scale=scale, R=pose.R, t=pose.t), poses, st.floats(0.05, 20)
)


@given(poses, poses, poses)
def test_composition_is_associative(a, b, c):
    np.testing.assert_allclose(((a @ b) @ c).matrix, (a @ (b @ c)).matrix, atol=1e-12)


@given(poses)
def test_the_inverse_undoes_on_both_sides(pose):
    np.testing.assert_allclose((pose @ pose.inverse()).matrix, np.eye(4), atol=1e-12)
    np.testing.assert_allclose((pose.inverse() @ pose).matrix, np.eye(4), atol=1e-12)


@given(poses, poses, clouds)
def test_composing_is_mapping_one_after_the_other(a, b, points):
    np.testing.assert_allclose(
        (a @ b).transform(points), a.transform(b.transform(points)), atol=1e-11
    )


@given(poses, clouds)
def test_distances_stay(pose, points):
    moved = pose.transform(points)
    before = np.linalg.norm(points[1:] - points[0], axis=1)
    np.testing.assert_allclose(np.linalg.norm(moved[1:] - moved[0], axis=1), before, atol=1e-12)


@given(poses)
def test_every_notation_leads_back(pose):
    again = Pose.from_quat_xyzw(pose.quat_xyzw, pose.t)
    np.testing.assert_allclose(again.matrix, pose.matrix, atol=1e-12)
    np.testing.assert_allclose(Pose.from_matrix(pose.matrix).matrix, pose.matrix, atol=0)
    again = Pose.from_rotvec(pose.rotvec_rad, pose.t)
    np.testing.assert_allclose(again.matrix, pose.matrix, atol=1e-7)
    assert pose.quat_xyzw[3] >= 0


@given(st.lists(poses, min_size=60, max_size=60))
def test_long_products_stay_rotations(chain):
    product = chain[0]
    for pose in chain[1:]:
        product = product @ pose
    np.testing.assert_allclose(product.R @ product.R.T, np.eye(3), atol=1e-12)


@given(similarities, clouds)
def test_a_similarity_is_found_again_from_points(S, points):
    found = fit_similarity(points, S.transform(points))
    assert found is not None
    assert abs(found.scale / S.scale - 1) < 1e-9
    np.testing.assert_allclose(found.R, S.R, atol=1e-9)
    np.testing.assert_allclose(found.t, S.t, atol=1e-8 * S.scale + 1e-9)


@given(similarities, st.lists(poses, min_size=2, max_size=6))
def test_a_similarity_is_found_again_from_poses(S, cameras):
    spread = np.linalg.norm(cameras[0].t - cameras[1].t)
    found = fit_similarity_of_poses(cameras, [S.transform_pose(T) for T in cameras])
    if spread < 1e-3:
        return
    assert found is not None
    assert abs(found.scale / S.scale - 1) < 1e-6
    np.testing.assert_allclose(found.R, S.R, atol=1e-6)


@given(similarities, poses)
def test_a_similarity_and_its_inverse_cancel(S, pose):
    again = S.inverse().transform_pose(S.transform_pose(pose))
    np.testing.assert_allclose(again.matrix, pose.matrix, atol=1e-9)


def test_poses_of_one_place_have_no_scale():
    turns = [Pose.from_rotvec([0, 0, a], [1.0, 2.0, 3.0]) for a in (0.0, 0.4, 0.9)]
    assert fit_similarity_of_poses(turns, turns) is None
