"""Videos of other codecs, in parts, and in the native recording."""

import struct

import av
import cv2
import numpy as np
import pytest

from gazemap.errors import InputError
from gazemap.geometry.camera import Camera
from gazemap.session import open_session
from gazemap.session.mcap_read import McapFile
from gazemap.session.mcap_session import open_mcap
from gazemap.session.mcap_write import McapWriter, Writer, write_mcap
from gazemap.session.records import Record, record_of
from gazemap.wire import images, rig
from gazemap.wire.images import CodedImage, ImageFormat, VideoPacket
from gazemap.wire.schemas import VIDEO
from gazemap.wire.streams import Stream
from tests.session_writer import write_video

CAMERA = Camera(
    width_px=160,
    height_px=120,
    K=np.array([[150.0, 0, 80], [0, 150, 60], [0, 0, 1]]),
    distortion=np.zeros(4),
)


def available(codec):
    try:
        av.codec.Codec(codec, "w")
    except ValueError:
        return False
    return True


def assert_same_frames(one, other):
    pairs = list(zip(one.scene_frames(), other.scene_frames(), strict=True))
    assert pairs
    for a, b in pairs:
        assert (a.index, a.t_ns) == (b.index, b.t_ns)
        np.testing.assert_array_equal(a.image, b.image)


@pytest.mark.parametrize(
    ("codec", "pixels", "stored"),
    [
        ("libx264", "yuv444p", VideoPacket),
        ("libx265", "yuv420p", VideoPacket),
        ("mpeg4", "yuv420p", CodedImage),
        ("ffv1", "gray", CodedImage),
    ],
)
def test_every_codec_comes_back_to_the_bit(writer, tmp_path, codec, pixels, stored):
    if not available(codec):
        pytest.skip(f"this FFmpeg does not write {codec}")
    write_video(writer.path / "scene.mp4", codec=codec, pixels=pixels)
    session = open_session(writer.path)
    write_mcap(session, tmp_path / "a.mcap")
    again = open_session(tmp_path / "a.mcap")
    assert_same_frames(session, again)
    assert isinstance(next(iter(again.scene.coded())), stored)
    image = next(iter(session.scene_frames())).image
    assert image.shape == ((120, 160) if pixels == "gray" else (120, 160, 3))


def test_a_phones_video_in_parts_is_one_recording(tmp_path):
    folder = tmp_path / "phone"
    folder.mkdir()
    numbers = [1500.0, 0, 800, 0, 1500, 600, 0, 0, 1, *[0.0] * 8]
    (folder / "calibration.bin").write_bytes(struct.pack("<B6s17d", 1, b"123456", *numbers))
    for part, first in ((1, 0), (2, 10), (10, 16)):
        count = 10 if part == 1 else 6
        name = f"Neon Scene Camera v1 ps{part}"
        write_video(folder / f"{name}.mp4", count=count, first=first)
        times = np.arange(first, first + count, dtype="<i8") * 7
        (folder / f"{name}.time").write_bytes(times.tobytes())
    with pytest.raises(InputError, match="1600x1200 pixels expected, got 160x120"):
        open_session(folder)
    camera = tmp_path / "camera.json"
    camera.write_text(
        '{"camera_matrix": [[1500, 0, 800], [0, 1500, 600], [0, 0, 1]], "dist_coefs": [0,0,0,0]}'
    )
    for part in folder.glob("*.mp4"):
        with_size(part, 1600, 1200)
    session = open_session(folder, camera=camera)
    assert session.scene_t_ns == tuple(7 * i for i in range(22))
    assert [f.index for f in session.scene_frames()] == list(range(22))
    write_mcap(session, tmp_path / "a.mcap")
    assert_same_frames(session, open_session(tmp_path / "a.mcap"))


def with_size(path, width_px, height_px):
    """Write a video anew, larger."""
    with av.open(str(path)) as container:
        pictures = [f.to_ndarray(format="bgr24") for f in container.decode(video=0)]
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30, options={"preset": "ultrafast"})
        stream.width, stream.height, stream.pix_fmt = width_px, height_px, "yuv420p"
        for picture in pictures:
            large = cv2.resize(picture, (width_px, height_px))
            container.mux(stream.encode(av.VideoFrame.from_ndarray(large, format="bgr24")))
        container.mux(stream.encode())


def write_records(path, records):
    with path.open("wb") as file:
        writer = McapWriter(Writer(file))
        for record in records:
            writer.write(record)
        writer.finish()
    return path


def calibration(stream=Stream.HEAD_CALIBRATION):
    return record_of(stream, 0, images.encode_calibration(CAMERA, frame_id="head"))


def image_at(t_ns, *, shape=(120, 160, 3)):
    data = cv2.imencode(".png", np.full(shape, t_ns, dtype=np.uint8))[1].tobytes()
    image = CodedImage(index=0, t_ns=t_ns, image_format=ImageFormat.PNG, data=data)
    return record_of(Stream.HEAD_IMAGE, t_ns, images.encode_coded_image(image, frame_id="head"))


def packet(t_ns, *, codec="h264", data=b"\x00\x00\x00\x01junk"):
    sent = images.encode_packet(
        VideoPacket(index=0, t_ns=t_ns, codec=codec, data=data), frame_id="head"
    )
    return Record(log_ns=t_ns, stream=Stream.HEAD_IMAGE, payload=sent, schema=VIDEO)


def test_an_image_that_is_not_after_the_one_before_is_left_out(tmp_path):
    times = (5, 9, 9, 7, 12)
    path = write_records(tmp_path / "a.mcap", [calibration(), *map(image_at, times)])
    session = open_mcap(path, camera=None)
    assert session.scene_t_ns == (5, 9, 12)
    assert [(f.index, f.t_ns, int(f.image[0, 0, 0])) for f in session.scene_frames()] == [
        (0, 5, 5),
        (1, 9, 9),
        (2, 12, 12),
    ]


def test_an_image_of_another_size_is_refused(tmp_path):
    path = write_records(tmp_path / "a.mcap", [calibration(), image_at(1, shape=(60, 80, 3))])
    with pytest.raises(InputError, match="160x120 pixels expected, got 80x60"):
        list(open_mcap(path, camera=None).scene_frames())


def test_a_recording_without_images_says_so_when_they_are_asked_for(tmp_path):
    cue = record_of(Stream.NARRATION, 3, rig.encode_cue(rig.Cue(start_ns=1, end_ns=3, text="go")))
    session = open_mcap(write_records(tmp_path / "a.mcap", [calibration(), cue]), camera=None)
    assert session.data.narration[0].text == "go"
    assert (session.scene_t_ns, list(session.scene.coded())) == ((), [])
    with pytest.raises(InputError, match="no scene video"):
        list(session.scene_frames())


def test_a_recording_without_calibration_is_refused(tmp_path):
    path = write_records(tmp_path / "a.mcap", [image_at(1)])
    with pytest.raises(InputError, match="no calibration of the head camera"):
        open_mcap(path, camera=None)


@pytest.mark.parametrize("codec", ["h264", "no-such-codec", "aac"])
def test_packets_that_are_no_video_are_refused(tmp_path, codec):
    path = write_records(tmp_path / "a.mcap", [calibration(), packet(1, codec=codec), packet(2)])
    with pytest.raises(InputError, match=r"can be read|is unknown"):
        list(open_mcap(path, camera=None).scene_frames())


def test_depth_is_kept_to_the_millimetre(writer, tmp_path):
    (writer.path / "depth").mkdir()
    for i in range(24):
        depth_mm = np.full((120, 160), 500 + i, dtype=np.uint16)
        depth_mm[0] = 0
        cv2.imwrite(str(writer.path / "depth" / f"{i:03}.png"), depth_mm)
    session = open_session(writer.path)
    write_mcap(session, tmp_path / "a.mcap")
    again = open_session(tmp_path / "a.mcap")
    assert again.scene_depth.t_ns == session.scene_t_ns
    for a, b in zip(session.scene_depth_frames(), again.scene_depth_frames(), strict=True):
        assert a.t_ns == b.t_ns
        np.testing.assert_array_equal(a.depth_m, b.depth_m)
    assert list(again.overhead_depth_frames()) == []
    assert len(list(again.scene_depth.coded())) == 24


def test_topics_of_others_are_passed_over(tmp_path):
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        number = writer.register_channel("robot/arm", "json", 0)
        writer.add_message(number, 1, b"{}", 1)
        writer.finish()
    assert list(McapFile(path).messages()) == []
