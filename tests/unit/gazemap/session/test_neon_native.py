import struct

import numpy as np
import pytest

from gazemap.errors import InputError
from gazemap.session import open_session

K = [[90.0, 0, 80.0], [0, 91.0, 60.0], [0, 0, 1]]
EVENTS = '[("event_type","int32"),("start_timestamp_ns","int64"),("end_timestamp_ns","int64"),'


def write_array(path, values, kind):
    path.write_bytes(np.array(values, dtype=kind).tobytes())


@pytest.fixture
def phone(tmp_path):
    """A phone's recording without video, in two parts of gaze."""
    numbers = [*np.ravel(K), *np.linspace(0, 0.07, 8)]
    (tmp_path / "calibration.bin").write_bytes(struct.pack("<B6s17d", 1, b"123456", *numbers))
    for part, times in ((1, [100, 200]), (2, [300, 300, 400])):
        write_array(tmp_path / f"gaze ps{part}.time", times, "<i8")
        write_array(tmp_path / f"gaze ps{part}.raw", [[t, t + 1] for t in times], "<f4")
    write_array(tmp_path / "worn ps1.raw", [255, 0, 10], "u1")
    rows = np.array([(1, 100, 200, 5, 6), (0, 200, 250, 7, 8), (1, 250, 400, 9, 10)], dtype=object)
    named = EVENTS + '("mean_gaze_x","float32"),("mean_gaze_y","float32")]'
    (tmp_path / "fixations.dtype").write_text(named)
    packed = b"".join(struct.pack("<iqqff", *row) for row in rows)
    (tmp_path / "fixations ps1.raw").write_bytes(packed)
    (tmp_path / "blinks.dtype").write_text(EVENTS + "]")
    (tmp_path / "blinks ps1.raw").write_bytes(struct.pack("<iqq", 4, 150, 310))
    vectors = [b"".join(struct.pack("<Bf", 13 + 8 * k, v) for k, v in enumerate((0.5, 0, 1)))] * 2
    body = b"\x08\x05" + b"".join(bytes([18 + 8 * k, 15]) + v for k, v in enumerate(vectors))
    (tmp_path / "extimu ps1.raw").write_bytes((struct.pack("<H", len(body)) + body) * 2)
    write_array(tmp_path / "extimu ps1.time", [100, 110], "<i8")
    return tmp_path


def test_parts_are_joined_and_repeated_times_count_once(phone):
    gaze = open_session(phone).data.gaze
    assert gaze.t_ns.tolist() == [100, 200, 300, 400]
    np.testing.assert_array_equal(gaze.uv_px[:, 1], [101, 201, 301, 401])
    assert gaze.worn.tolist() == [True, False, True, True]
    assert gaze.blink.tolist() == [False, True, True, False]


def test_gaze_that_was_sampled_up_is_preferred(phone):
    write_array(phone / "gaze_200hz.time", [1, 2, 3], "<i8")
    write_array(phone / "gaze_200hz.raw", [[1, 1]] * 3, "<f4")
    assert open_session(phone).data.gaze.t_ns.tolist() == [1, 2, 3]


def test_fixations_are_told_from_saccades(phone):
    fixations = open_session(phone).data.fixations
    assert [(f.fixation_id, f.start_ns, f.u_px) for f in fixations] == [(1, 100, 5), (2, 250, 9)]


def test_inertial_packets_are_in_si_units(phone):
    imu = open_session(phone).data.imu
    np.testing.assert_allclose(imu.accel_m_s2[0], np.array([0.5, 0, 1]) * 9.80665)
    np.testing.assert_allclose(imu.gyro_rad_s[1], np.radians([0.5, 0, 1]))


def test_a_recording_without_video_says_so_when_frames_are_asked_for(phone):
    session = open_session(phone)
    assert session.scene_t_ns == ()
    assert session.scene_camera.serial == "123456"
    np.testing.assert_array_equal(session.scene_camera.K, K)
    assert "no scene video" in session.data.warnings[0]
    with pytest.raises(InputError, match="no scene video"):
        list(session.scene_frames())


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("calibration.bin", b"short"),
        ("gaze ps1.raw", b"123"),
        ("gaze ps1.time", bytes(8)),
        ("gaze ps2.time", np.array([3, 2, 1], dtype="<i8").tobytes()),
        ("fixations.dtype", b"import os"),
        ("extimu ps1.raw", b"\x50\x00abc"),
    ],
)
def test_a_damaged_part_is_refused_by_name(phone, name, content):
    (phone / name).write_bytes(content)
    with pytest.raises(InputError) as caught:
        open_session(phone)
    assert "\n" not in str(caught.value)
    assert name.split()[0].split(".")[0] in str(caught.value)
