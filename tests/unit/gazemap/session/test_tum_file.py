import numpy as np
import pytest

from gazemap.errors import InputError
from gazemap.session.tum_file import read_tum, write_tum
from gazemap.types.tracking import Scale, Trajectory

T0_NS = 1_760_000_000_000_000_123


@pytest.fixture
def trajectory():
    return Trajectory(
        t_ns=np.array([T0_NS, T0_NS + 33_333_333]),
        quat_xyzw=np.array([[0, 0, 0, 1], [0, 0.6, 0, 0.8]]),
        p_world_cam=np.array([[1.0, -2.0, 0.5], [1.1, -2.0, 0.25]]),
        scale=Scale.METRIC,
        map_id=3,
    )


def test_a_written_trajectory_is_read_back_to_the_nanosecond(trajectory, tmp_path):
    write_tum(trajectory, tmp_path / "a.tum")
    back = read_tum(tmp_path / "a.tum")
    assert back.t_ns.tolist() == trajectory.t_ns.tolist()
    np.testing.assert_allclose(back.p_world_cam, trajectory.p_world_cam, atol=1e-9)
    np.testing.assert_allclose(back.quat_xyzw, trajectory.quat_xyzw, atol=1e-9)
    assert (back.scale, back.map_id) == (Scale.METRIC, 3)


def test_a_row_has_nine_decimals_in_the_time_and_eight_fields(trajectory, tmp_path):
    write_tum(trajectory, tmp_path / "a.tum")
    first = (tmp_path / "a.tum").read_text().splitlines()[0].split()
    assert first[0] == "1760000000.000000123"
    assert len(first) == 8


def test_a_file_without_facts_beside_it_has_arbitrary_scale(trajectory, tmp_path):
    write_tum(trajectory, tmp_path / "a.tum")
    (tmp_path / "a.json").unlink()
    assert read_tum(tmp_path / "a.tum").scale is Scale.ARBITRARY


def test_a_broken_row_is_named_with_its_line(tmp_path):
    (tmp_path / "b.tum").write_text("# comment\n1.0 0 0 0 0 0 0 1\n2.0 0 zero 0\n")
    with pytest.raises(InputError, match=r"b\.tum:3: eight numbers expected"):
        read_tum(tmp_path / "b.tum")
