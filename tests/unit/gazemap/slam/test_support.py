"""The plane a wearer works at, found in a sparse map."""

import numpy as np
from scipy.spatial.transform import Rotation

from gazemap.slam.support import find_support

NORMAL = Rotation.from_rotvec([0.3, -0.2, 0.1]).apply([0.0, 0.0, 1.0])
OFFSET = 0.4
UP = Rotation.from_rotvec([0.7, 0.0, 0.0]).apply(NORMAL)  # a head that looks down by 40 degrees


def drawn_map(rng, *, on_plane=300, beside=100, noise=0.002):
    """Points on a table and clutter over it, in units of the distance the head looks from."""
    turn = Rotation.align_vectors([NORMAL], [[0.0, 0.0, 1.0]])[0]
    flat = np.column_stack([rng.uniform(-0.5, 0.5, (on_plane, 2)), rng.normal(0, noise, on_plane)])
    above = rng.uniform([-0.5, -0.5, 0.02], [0.5, 0.5, 0.5], (beside, 3))
    return turn.apply(np.concatenate([flat, above])) + OFFSET * NORMAL


def origins(rng):
    return NORMAL * (OFFSET + 0.8) + rng.normal(0, 0.05, (20, 3))


def found(points, rng):
    return find_support(points, origins_map=origins(rng), up_map=UP, rng=rng)


def test_the_table_is_found_among_clutter():
    rng = np.random.default_rng(1)
    support = found(drawn_map(rng), rng)
    assert support is not None
    assert np.degrees(np.arccos(support.normal_map @ NORMAL)) < 0.3
    assert abs(support.offset - OFFSET) < 0.002


def test_the_cameras_are_on_its_upper_side():
    rng = np.random.default_rng(2)
    support = found(drawn_map(rng), rng)
    assert support is not None
    assert (origins(rng) @ support.normal_map > support.offset).all()


def test_a_cloud_has_no_support():
    rng = np.random.default_rng(3)
    assert found(rng.uniform(-0.5, 0.5, (400, 3)), rng) is None


def test_a_wall_is_no_support():
    rng = np.random.default_rng(4)
    ahead = np.cross(UP, [1.0, 0.0, 0.0])
    ahead /= np.linalg.norm(ahead)
    side = np.cross(ahead, UP)
    grid = rng.uniform(-0.5, 0.5, (400, 2))
    wall = grid[:, :1] * UP + grid[:, 1:] * side + ahead
    support = find_support(wall, origins_map=rng.normal(0, 0.02, (20, 3)), up_map=UP, rng=rng)
    assert support is None


def test_few_points_are_no_map():
    rng = np.random.default_rng(5)
    assert found(drawn_map(rng, on_plane=20, beside=0), rng) is None
