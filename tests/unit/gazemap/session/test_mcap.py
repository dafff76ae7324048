import dataclasses
import json
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from mcap.reader import make_reader

from gazemap.errors import InputError
from gazemap.session import open_session
from gazemap.session.mcap_write import write_mcap

ROOT = Path(__file__).resolve().parents[4]


def fill(writer):
    """Add the streams that the common folder lacks."""
    start = writer.start_ns
    writer.text(
        "fixations.csv",
        "fixation id,start timestamp [ns],end timestamp [ns],fixation x [px],fixation y [px]\n"
        f"4,{start},{start + 5000},10.25,20.5\n7,{start + 6000},{start + 9000},11,21\n",
    )
    writer.text(
        "imu.csv",
        "timestamp [ns],gyro x [deg/s],gyro y [deg/s],gyro z [deg/s],"
        "acceleration x [g],acceleration y [g],acceleration z [g]\n"
        f"{start},1,2,3,0.1,0.2,0.97\n{start + 10},4,5,6,0.1,0.2,0.97\n",
    )
    writer.text("blinks.csv", f"start timestamp [ns],end timestamp [ns]\n{start + 1},{start + 2}\n")
    writer.text("events.csv", f"timestamp [ns],name\n{start + 3},begin\n")
    writer.text("info.json", json.dumps({"wearer_heading_rad": -0.5, "deep": {"a": [1, None]}}))
    writer.camera(readout_s=0.012)
    writer.video("overhead.mp4", count=4)
    writer.times("overhead_timestamps.csv", [start + 50_000_000 * i for i in range(4)])
    writer.text("overhead_camera.json", (writer.path / "scene_camera.json").read_text())


@pytest.fixture
def pair(writer, tmp_path):
    """The same session as a folder and as one file."""
    fill(writer)
    folder = open_session(writer.path)
    write_mcap(folder, tmp_path / "copy.mcap")
    return folder, open_session(tmp_path / "copy.mcap")


def assert_equal_arrays(a, b):
    for field in dataclasses.fields(a):
        np.testing.assert_array_equal(getattr(a, field.name), getattr(b, field.name))


def test_the_images_are_equal_to_the_bit(pair):
    folder, file = pair
    assert file.scene_t_ns == folder.scene_t_ns
    assert file.overhead_t_ns == folder.overhead_t_ns
    for one, other in (
        (folder.scene_frames(), file.scene_frames()),
        (folder.overhead_frames(), file.overhead_frames()),
    ):
        for a, b in zip(one, other, strict=True):
            assert (a.index, a.t_ns) == (b.index, b.t_ns)
            np.testing.assert_array_equal(a.image, b.image)


def test_every_stream_comes_back(pair):
    folder, file = pair
    names = ("fixations", "blinks", "events", "narration", "wearer_heading_rad", "info", "warnings")
    for name in names:
        assert getattr(file.data, name) == getattr(folder.data, name)
    assert_equal_arrays(file.data.gaze, folder.data.gaze)
    assert_equal_arrays(file.data.imu, folder.data.imu)
    (one,), (other,) = folder.data.tags.tags, file.data.tags.tags
    assert (one.tag_id, one.size_m) == (other.tag_id, other.size_m)
    np.testing.assert_allclose(one.T_world_tag.matrix, other.T_world_tag.matrix, atol=1e-12)
    assert file.data.name == "copy"


def test_the_cameras_come_back(pair):
    folder, file = pair
    for a, b in (
        (folder.scene_camera, file.scene_camera),
        (folder.overhead_camera, file.overhead_camera),
    ):
        np.testing.assert_array_equal(a.K, b.K)
        np.testing.assert_array_equal(a.distortion, b.distortion)
        assert (a.lens, a.serial, a.readout_s) == (b.lens, b.serial, 0.012)


def test_an_empty_stream_is_told_from_one_that_is_not_there(writer, tmp_path):
    write_mcap(open_session(writer.path), tmp_path / "a.mcap")
    assert open_session(tmp_path / "a.mcap").data.fixations is None
    header = "fixation id,start timestamp [ns],end timestamp [ns],fixation x [px],fixation y [px]\n"
    writer.text("fixations.csv", header)
    write_mcap(open_session(writer.path), tmp_path / "b.mcap")
    assert open_session(tmp_path / "b.mcap").data.fixations == ()


@pytest.mark.usefixtures("pair")
def test_another_reader_finds_topics_and_schemas(tmp_path):
    with (tmp_path / "copy.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    schemas = {c.topic: summary.schemas[c.schema_id] for c in summary.channels.values()}
    assert schemas["head/image"].name == "foxglove.CompressedVideo"
    assert schemas["head/calibration"].name == "foxglove.CameraCalibration"
    assert schemas["gaze"].name == "gazemap.v1.GazeSample"
    files = FileDescriptorSet.FromString(schemas["head/image"].data).file
    assert {f.name for f in files} >= {"google/protobuf/timestamp.proto"}


def test_a_cut_file_is_read_up_to_its_last_whole_chunk(writer, tmp_path):
    folder = open_session(writer.path)
    whole = tmp_path / "whole.mcap"
    write_mcap(folder, whole, chunk_bytes=1000)
    with whole.open("rb") as file:
        chunks = make_reader(file).get_summary().chunk_indexes
    late = next(chunk for chunk in chunks if chunk.message_start_time > folder.scene_t_ns[12])
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole.read_bytes()[: late.chunk_start_offset + 100])
    session = open_session(cut)
    frames = list(session.scene_frames())
    assert 2 < len(frames) < 22
    assert [f.t_ns for f in frames] == list(session.scene_t_ns)
    originals = {f.t_ns: f.image for f in folder.scene_frames()}
    for frame in frames:
        np.testing.assert_array_equal(frame.image, originals[frame.t_ns])
    assert "cut off" in session.data.warnings[-1]


@pytest.mark.parametrize("content", [b"", b"hello", b"\x89MCAP0\r\n"])
def test_a_file_that_is_no_recording_is_refused(tmp_path, content):
    path = tmp_path / "x.mcap"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"x\.mcap"):
        open_session(path)


def test_a_failed_writing_leaves_nothing(writer, tmp_path):
    session = open_session(writer.path)
    (writer.path / "scene.mp4").unlink()
    with pytest.raises(OSError, match="No such file"):
        write_mcap(session, tmp_path / "out" / "a.mcap")
    assert list((tmp_path / "out").iterdir()) == []


def test_images_keep_their_bytes(tmp_path):
    rng = np.random.default_rng(3)
    folder = tmp_path / "shots"
    folder.mkdir()
    for name in ("a.jpg", "b.png", "c.bmp"):
        cv2.imwrite(str(folder / name), rng.integers(0, 255, (60, 80, 3), dtype=np.uint8))
    (folder / "scene_camera.json").write_text(
        '{"camera_matrix": [[90, 0, 40], [0, 90, 30], [0, 0, 1]], "dist_coefs": [0, 0, 0, 0]}'
    )
    session = open_session(folder)
    write_mcap(session, tmp_path / "shots.mcap")
    again = open_session(tmp_path / "shots.mcap")
    for a, b in zip(session.scene_frames(), again.scene_frames(), strict=True):
        np.testing.assert_array_equal(a.image, b.image)
    stored = [image.data for image in again.scene.coded()]
    assert stored == [(folder / name).read_bytes() for name in ("a.jpg", "b.png", "c.bmp")]


def test_progress_is_told_frame_by_frame(writer, tmp_path):
    told = []
    write_mcap(
        open_session(writer.path),
        tmp_path / "a.mcap",
        progress=lambda stage, done, total: told.append((stage, done, total)),
    )
    assert told == [("writing", i, 24) for i in range(1, 25)]


# Decoders are closed while their threads still hold packets; a lock taken twice shows in a few.
ABANDON = """
import sys
from pathlib import Path
from gazemap.session import open_session
session = open_session(Path(sys.argv[1]))
for _ in range(100):
    next(iter(session.scene_frames()))
"""


def test_frames_that_nobody_reads_on_never_block(writer, tmp_path):
    writer.video("scene.mp4", scale=8)
    writer.camera(camera_matrix=[[900.0, 0, 640], [0, 900, 480], [0, 0, 1]])
    write_mcap(open_session(writer.path), tmp_path / "a.mcap")
    done = subprocess.run(
        [sys.executable, "-c", ABANDON, tmp_path / "a.mcap"], cwd=ROOT, timeout=60, check=False
    )
    assert done.returncode == 0
