from fractions import Fraction

import av
import cv2
import numpy as np
import pytest

from gazemap.errors import InputError
from gazemap.geometry.camera import LensModel
from gazemap.session import open_session
from tests.session_writer import picture_of


def refused(path):
    """The one line that says why a folder cannot be used."""
    with pytest.raises(InputError) as caught:
        for _ in open_session(path).scene_frames():
            pass
    assert "\n" not in str(caught.value)
    assert caught.value.todo
    return str(caught.value)


def test_frames_have_the_times_of_the_table_and_their_own_pictures(writer):
    session = open_session(writer.path)
    frames = list(session.scene_frames())
    assert [f.t_ns for f in frames] == writer.frame_t_ns
    assert list(session.scene_t_ns) == writer.frame_t_ns
    assert [f.index for f in frames] == list(range(24))
    for frame in frames:
        assert frame.image.shape == (120, 160, 3)
        assert abs(float(frame.image.mean()) - (12.5 + 9 * frame.index)) < 3


def test_every_call_decodes_anew(writer):
    session = open_session(writer.path)
    first = [f.image.tobytes() for f in session.scene_frames()]
    assert [f.image.tobytes() for f in session.scene_frames()] == first


def test_streams_are_read_with_their_units_and_names(writer):
    writer.text(
        "imu.csv",
        "timestamp [ns],gyro x [deg/s],gyro y [deg/s],gyro z [deg/s],"
        "acceleration x [g],acceleration y [g],acceleration z [g],roll [deg]\n"
        "5,180,0,-90,0,0,1,7\n",
    )
    writer.text(
        "blinks.csv", "blink id,start timestamp [ns],end timestamp [ns],duration [ms]\n1,3,9,0\n"
    )
    writer.text("events.csv", "recording id,timestamp [ns],name,type\nr,4,begin,recording\n")
    writer.text("info.json", '{"wearer_heading_rad": 1.5, "other": [1]}')
    data = open_session(writer.path).data
    assert data.name == "walk"
    assert data.imu is not None
    np.testing.assert_allclose(data.imu.gyro_rad_s, [[np.pi, 0, -np.pi / 2]])
    np.testing.assert_allclose(data.imu.accel_m_s2, [[0, 0, 9.80665]])
    assert [(b.start_ns, b.end_ns) for b in data.blinks] == [(3, 9)]
    assert [(e.t_ns, e.name) for e in data.events] == [(4, "begin")]
    assert data.wearer_heading_rad == 1.5
    assert data.info["other"] == [1]


def test_what_is_not_there_is_none_or_empty(writer):
    for name in ("gaze.csv", "narration.vtt", "tags.yaml"):
        (writer.path / name).unlink()
    session = open_session(writer.path)
    assert session.data.gaze is session.data.fixations is session.data.tags is None
    assert session.data.narration == session.data.blinks == ()
    assert session.overhead_camera is None
    assert list(session.overhead_frames()) == list(session.scene_depth_frames()) == []


def test_gaze_without_a_point_is_kept_as_nan_and_told(writer):
    data = open_session(writer.path).data
    np.testing.assert_array_equal(data.gaze.t_ns - writer.start_ns, [1e6, 6e6, 11e6])
    np.testing.assert_array_equal(np.isnan(data.gaze.uv_px[:, 0]), [False, True, False])
    np.testing.assert_array_equal(data.gaze.worn, [True, True, False])
    np.testing.assert_array_equal(data.gaze.blink, [False, True, False])
    assert data.warnings == ("gaze.csv: 1 of 3 samples have no gaze point",)


def test_a_repeated_gaze_time_counts_once_and_is_told(writer):
    writer.gaze([writer.gaze_row(1), writer.gaze_row(1, u="99"), writer.gaze_row(2)])
    data = open_session(writer.path).data
    np.testing.assert_array_equal(data.gaze.uv_px[:, 0], [10.5, 10.5])
    assert "1 rows repeat a time" in data.warnings[0]


def test_unsorted_gaze_is_refused_with_its_line(writer):
    writer.gaze([writer.gaze_row(1), writer.gaze_row(9, u="", v=""), writer.gaze_row(5)])
    assert "gaze.csv, line 4" in refused(writer.path)


@pytest.mark.parametrize("text", ["nan", "inf", "left", "1,5"])
def test_a_gaze_field_that_is_no_number_is_refused_with_its_line(writer, text):
    writer.gaze([writer.gaze_row(1), writer.gaze_row(2, u=f'"{text}"')])
    assert "gaze.csv, line 3: column 'gaze x [px]'" in refused(writer.path)


def test_gaze_of_another_time_than_the_video_is_refused(writer):
    writer.gaze([writer.gaze_row(3_600_000)])
    assert "outside the video" in refused(writer.path)


def test_a_row_that_was_cut_is_refused(writer):
    writer.gaze([writer.gaze_row(1), writer.gaze_row(2)[:20]])
    assert "gaze.csv, line 3: 10 fields expected, got 3" in refused(writer.path)


def test_a_missing_column_is_named(writer):
    writer.text("gaze.csv", "timestamp [ns],gaze x [px]\n5,1\n")
    assert "no column 'gaze y [px]'" in refused(writer.path)


def test_times_with_an_exponent_are_refused(writer):
    writer.text("gaze.csv", "timestamp [ns],gaze x [px],gaze y [px]\n1.76e18,1,1\n")
    assert "an integer expected, got '1.76e18'" in refused(writer.path)


def test_further_columns_and_other_orders_are_fine(writer):
    writer.text(
        "gaze.csv", f"gaze y [px],more,gaze x [px],timestamp [ns]\n2,x,1,{writer.start_ns}\n"
    )
    gaze = open_session(writer.path).data.gaze
    np.testing.assert_array_equal(gaze.uv_px, [[1, 2]])
    assert gaze.worn.all()


def test_a_missing_video_is_refused(writer):
    (writer.path / "scene.mp4").unlink()
    assert "scene.mp4: the scene video is missing" in refused(writer.path)


def test_the_one_other_video_serves(writer):
    (writer.path / "scene.mp4").rename(writer.path / "abc_0-24.mp4")
    assert len(list(open_session(writer.path).scene_frames())) == 24


def test_two_other_videos_are_refused_by_name(writer):
    writer.video("b.mp4", count=1)
    (writer.path / "scene.mp4").rename(writer.path / "a.mp4")
    assert "a.mp4, b.mp4" in refused(writer.path)


def test_a_video_that_was_cut_before_its_index_is_refused(writer):
    writer.cut("scene.mp4", share=0.5)
    assert "scene.mp4: 0 of 24 frames can be read" in refused(writer.path)


def test_a_video_that_was_cut_after_its_index_is_refused_with_what_is_left(writer):
    writer.video("scene.mp4", faststart=True)
    writer.cut("scene.mp4", share=0.8)
    line = refused(writer.path)
    left = int(line.split("scene.mp4: ")[1].split(" of 24 frames can be read")[0])
    assert 2 < left < 22


def test_a_video_that_is_damaged_inside_is_refused(writer):
    file = writer.path / "scene.mp4"
    content = bytearray(file.read_bytes())
    start = content.find(b"mdat") + 4
    content[start + 40 : start + 2500] = bytes(2460)
    file.write_bytes(content)
    assert "of 24 frames can be read" in refused(writer.path)


def test_a_video_without_timestamps_is_refused(writer):
    (writer.path / "world_timestamps.csv").unlink()
    assert "world_timestamps.csv: the video's timestamps are missing" in refused(writer.path)


@pytest.mark.parametrize("change", [-1, 1])
def test_timestamps_of_another_count_than_the_frames_are_refused(writer, change):
    times = writer.frame_t_ns
    writer.times("world_timestamps.csv", times[:change] if change < 0 else [*times, times[-1] + 1])
    assert "24" in refused(writer.path)


def test_frame_times_that_run_backwards_are_refused(writer):
    times = writer.frame_t_ns
    writer.times("world_timestamps.csv", [*times[:5], times[3], *times[6:]])
    assert "world_timestamps.csv, line 7" in refused(writer.path)


@pytest.mark.parametrize(
    "changes",
    [
        {"camera_matrix": [[300.0, 0, 161], [0, 302.0, 118], [0, 0, 1]]},
        {"camera_matrix": [[75.0, 0, 40], [0, 75.0, 30], [0, 0, 1]]},
        {"camera_matrix": [[120.0, 0, 64], [0, 120.0, 47.9], [0, 0, 1]]},
        {"resolution": [320, 240]},
        {"width": 200, "height": 120},
    ],
)
def test_a_camera_of_another_resolution_is_refused(writer, changes):
    writer.camera(**changes)
    assert "160x120" in refused(writer.path)


def test_an_odd_centre_is_accepted_where_the_file_states_the_size(writer):
    writer.camera(camera_matrix=[[150.0, 0, 40], [0, 150, 30], [0, 0, 1]], image_size=[160, 120])
    assert open_session(writer.path).scene_camera.K[0, 2] == 40


def test_older_and_newer_camera_files_are_read(writer):
    writer.camera(distortion_coefficients=None, dist_coefs=[0.1, 0.2, 0, 0], readout_s=0.012)
    camera = open_session(writer.path).scene_camera
    np.testing.assert_array_equal(camera.distortion, [0.1, 0.2, 0, 0])
    assert (camera.readout_s, camera.serial, camera.lens) == (0.012, "abc", LensModel.PINHOLE)
    assert (camera.width_px, camera.height_px) == (160, 120)
    writer.camera(distortion_coefficients=[0.1, 0.2, 0.3, 0], model="fisheye")
    assert open_session(writer.path).scene_camera.lens is LensModel.FISHEYE


@pytest.mark.parametrize(
    "changes",
    [
        {"camera_matrix": [[1, 0], [0, 1]]},
        {"camera_matrix": None},
        {"distortion_coefficients": [1, 2, 3]},
        {"distortion_coefficients": ["a"]},
        {"distortion_coefficients": [[0.1, 0.2], [0.3]]},
        {"model": "division"},
        {"readout_s": "12 ms"},
        {"readout_s": 12},
    ],
)
def test_a_malformed_camera_is_refused(writer, changes):
    writer.camera(**changes)
    assert "scene_camera.json" in refused(writer.path)


def test_another_camera_file_can_be_given(writer, tmp_path):
    other = tmp_path / "other.json"
    other.write_text((writer.path / "scene_camera.json").read_text().replace("151.0", "149.0"))
    (writer.path / "scene_camera.json").unlink()
    assert "scene_camera.json: the camera file is missing" in refused(writer.path)
    assert open_session(writer.path, camera=other).scene_camera.K[1, 1] == 149


def test_the_overhead_camera_has_times_of_its_own(writer):
    writer.video("overhead.mp4", count=3)
    writer.times("overhead_timestamps.csv", [10, 20, 35])
    camera = (writer.path / "scene_camera.json").read_text()
    writer.text("overhead_camera.json", camera)
    session = open_session(writer.path)
    assert [f.t_ns for f in session.overhead_frames()] == [10, 20, 35]
    assert session.overhead_t_ns == (10, 20, 35)


def test_a_folder_that_is_no_session_is_refused(tmp_path):
    (tmp_path / "notes.txt").write_text("hello")
    assert "no recording in it" in refused(tmp_path)
    assert "no such file or folder" in refused(tmp_path / "nowhere")


@pytest.mark.parametrize("name", ["gaze.csv", "narration.vtt", "tags.yaml"])
def test_a_folder_or_a_link_to_nowhere_is_not_taken_for_absent(writer, name):
    (writer.path / name).unlink()
    (writer.path / name).mkdir()
    assert f"{name}: cannot be read" in refused(writer.path)
    (writer.path / name).rmdir()
    (writer.path / name).symlink_to("nowhere")
    assert f"{name}: " in refused(writer.path)


@pytest.mark.parametrize("missing", ["overhead_timestamps.csv", "overhead_camera.json"])
def test_an_overhead_video_that_cannot_be_used_is_left_out_with_a_warning(writer, missing):
    writer.video("overhead.mp4")
    writer.times("overhead_timestamps.csv", writer.frame_t_ns)
    writer.text("overhead_camera.json", (writer.path / "scene_camera.json").read_text())
    assert open_session(writer.path).overhead_camera is not None
    (writer.path / missing).unlink()
    session = open_session(writer.path)
    assert session.overhead_camera is None
    assert f"overhead.mp4 is not used: there is no {missing}" in session.data.warnings


def test_times_before_1970_are_refused(writer):
    writer.times("world_timestamps.csv", [t - 2 * writer.start_ns for t in writer.frame_t_ns])
    assert "world_timestamps.csv, line 2: column 'timestamp [ns]'" in refused(writer.path)


def test_a_video_whose_frames_change_their_size_is_refused(writer):
    write_motion_jpeg(writer.path / "scene.mp4", [picture_of(i) for i in range(12)], half_from=7)
    writer.times("world_timestamps.csv", writer.frame_t_ns[:12])
    assert "frame 7 has 80x60 pixels, 160x120 expected" in refused(writer.path)


def write_motion_jpeg(path, pictures, *, half_from):
    """Write a video whose pictures are half as large from one on: each packet is a whole JPEG."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mjpeg", rate=30)
        stream.width, stream.height, stream.pix_fmt = 160, 120, "yuvj420p"
        for i, picture in enumerate(pictures):
            small = picture[::2, ::2] if i >= half_from else picture
            packet = av.Packet(cv2.imencode(".jpg", small)[1].tobytes())
            packet.stream, packet.time_base = stream, Fraction(1, 30)
            packet.pts = packet.dts = i
            container.mux(packet)


def test_nested_nonsense_is_one_line(writer):
    writer.text("info.json", "[" * 100_000)
    assert "info.json: no JSON" in refused(writer.path)
    writer.text("info.json", "{}")
    writer.text("tags.yaml", "family: [a]\ntags: 5\n")
    assert "tag family '['a']' is unknown" in refused(writer.path)
