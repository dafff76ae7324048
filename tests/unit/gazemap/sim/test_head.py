"""The head's path."""

import numpy as np
import pytest

from gazemap.sim.simulate import write_script
from tests.builders import small_config


@pytest.mark.parametrize("seed", range(4))
def test_head_moves_like_a_person_at_a_table(seed: int) -> None:
    head = write_script(small_config(seed=seed, seconds=20.0)).head
    t_s = np.arange(0.0, 20.0, 0.01)
    R, p = head.poses(t_s)
    assert np.allclose(np.einsum("nij,nkj->nik", R, R), np.eye(3), atol=1e-12)
    assert np.allclose(np.linalg.det(R), 1.0)
    speed = np.linalg.norm(np.diff(p, axis=0), axis=1) / 0.01
    assert 0.04 < np.median(speed) < 0.25
    assert speed.max() < 1.0
    step = np.einsum("nji,njk->nik", R[:-1], R[1:])
    turn = np.degrees(np.arccos(np.clip((np.trace(step, axis1=1, axis2=2) - 1) / 2, -1, 1))) / 0.01
    assert 6.0 < np.median(turn) < 25.0
    assert 25.0 < turn.max() < 130.0


def test_pose_is_continuous_in_time() -> None:
    head = write_script(small_config()).head
    _, p = head.poses(np.array([3.0, 3.0 + 1e-6]))
    assert np.abs(p[1] - p[0]).max() < 1e-5
