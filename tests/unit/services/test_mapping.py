"""The mapping service on a bus in memory: a rig's streams come in any order."""

import numpy as np
import pytest

from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Pose
from gazemap.live import LiveMappingConfig
from gazemap.slam.live.config import LiveConfig
from gazemap.types.frame import Frame
from gazemap.types.session import GazeSample, LayoutTag, TagLayout
from gazemap.types.status import Level
from gazemap.wire import images, rig
from gazemap.wire.images import ImageFormat
from gazemap.wire.rig import SessionInfo
from gazemap.wire.streams import Stream
from services.bus.memory import Exchange, MemoryBus
from services.mapping import MappingService, MappingServiceConfig

CAMERA = Camera(
    width_px=320,
    height_px=240,
    K=np.array([[300.0, 0, 160], [0, 300, 120], [0, 0, 1]]),
    distortion=np.zeros(5),
)
LAYOUT = TagLayout(
    family="tag36h11", tags=(LayoutTag(tag_id=0, size_m=0.06, T_world_tag=Pose.identity()),)
)
INTRODUCTION = {
    Stream.SESSION: rig.encode_session(SessionInfo(name="walk")),
    Stream.TAGS: rig.encode_tags(LAYOUT),
    Stream.HEAD_CALIBRATION: images.encode_calibration(CAMERA, frame_id="head"),
    Stream.OVERHEAD_CALIBRATION: images.encode_calibration(CAMERA, frame_id="overhead"),
}


def head_image(k):
    grey = np.random.default_rng(k).integers(0, 255, (240, 320), dtype=np.uint8)
    return image_of(grey, t_ns=k * 33_000_000)


def image_of(grey, *, t_ns):
    frame = Frame(index=0, t_ns=t_ns, image=grey)
    return images.encode_image(frame, frame_id="head", image_format=ImageFormat.PNG)


@pytest.fixture
def exchange():
    return Exchange()


@pytest.fixture
def service(exchange):
    config = MappingServiceConfig(live=LiveMappingConfig(tracking=LiveConfig(in_process=True)))
    one = MappingService(MemoryBus(exchange), config)
    yield one
    one._forget()


def drain(service):
    while (message := service.inbox.get(timeout_s=0.0)) is not None:
        service.take(message)
        service._begin_if_introduced()


def test_images_that_come_before_the_introduction_wait_for_it(exchange, service):
    bus = MemoryBus(exchange)
    for k in range(3):
        bus.publish(Stream.HEAD_IMAGE, head_image(k))
    drain(service)
    assert service._mapping is None
    for stream, payload in INTRODUCTION.items():
        bus.publish(stream, payload)
    drain(service)
    assert service._mapping is not None
    assert service._mapping._rig.layout.tags[0].tag_id == 0
    assert service._mapping._rig.overhead_camera is not None
    assert service._health.t_ns == 2 * 33_000_000


GAZE_CAMERA = {
    "camera_matrix": CAMERA.K.tolist(),
    "distortion_coefficients": [0, 0, 0, 0, 0],
    "width": 320,
    "height": 240,
    "T_scene_gaze": [[1, 0, 0, 0.04], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
}


def begin(exchange, service, info):
    told = {**INTRODUCTION, Stream.SESSION: rig.encode_session(SessionInfo(name="w", info=info))}
    publish_all(exchange, [*told.items(), (Stream.HEAD_IMAGE, head_image(0))])
    drain(service)
    return service._mapping._rig.gaze_camera


def test_a_rig_may_give_gaze_on_the_images_of_another_camera(exchange, service):
    eyes = begin(exchange, service, {"gaze_camera": GAZE_CAMERA})
    assert eyes.T_cam_gaze.t == pytest.approx([0.04, 0, 0])
    assert begin(exchange, service, {}) is None


def test_a_gaze_camera_that_is_none_is_named(exchange, service):
    assert begin(exchange, service, {"gaze_camera": {"width": 3}}) is None
    assert "info.json: gaze_camera" in complaints(service)


def test_a_broken_message_is_named_and_stops_nothing(exchange, service):
    bus = MemoryBus(exchange)
    for stream, payload in INTRODUCTION.items():
        bus.publish(stream, payload)
    bus.publish(Stream.TAGS, b"\xff no protobuf")
    bus.publish(Stream.HEAD_IMAGE, head_image(0))
    drain(service)
    assert service._health.level is Level.WARNING
    assert service._mapping is not None


def publish_all(exchange, messages):
    bus = MemoryBus(exchange)
    for stream, payload in messages:
        bus.publish(stream, payload)


def complaints(service):
    return " | ".join(service._health._complaints)


@pytest.mark.parametrize(
    ("stream", "payload", "said"),
    [
        (
            Stream.HEAD_IMAGE,
            image_of(np.zeros((90, 120), np.uint8), t_ns=99_000_000),
            "head/image: an image of 120x90 pixels, 320x240 expected",
        ),
        (Stream.HEAD_IMAGE, head_image(0), "head/image: an image that is not after the one before"),
        (
            Stream.TAGS,
            rig.encode_tags(TagLayout(family="tag99", tags=())),
            "tags: 0 tags of family 'tag99'; send at least one tag of",
        ),
        (
            Stream.GAZE,
            rig.encode_gaze(GazeSample(t_ns=2**62, u_px=1.0, v_px=1.0, worn=True, blink=False)),
            "gaze: far from the images' time",
        ),
    ],
)
def test_an_alien_message_is_one_line_and_the_map_goes_on(exchange, service, stream, payload, said):
    publish_all(exchange, [*INTRODUCTION.items(), (Stream.HEAD_IMAGE, head_image(1))])
    drain(service)
    mapping = service._mapping
    assert mapping is not None
    publish_all(exchange, [(stream, payload), (Stream.HEAD_IMAGE, head_image(4))])
    drain(service)
    assert said in complaints(service)
    assert service._mapping is mapping
    assert service._health.t_ns == 4 * 33_000_000


def test_a_clock_that_was_set_back_begins_another_map(exchange, service):
    publish_all(exchange, [*INTRODUCTION.items(), (Stream.HEAD_IMAGE, head_image(10**6))])
    drain(service)
    publish_all(exchange, [(Stream.HEAD_IMAGE, head_image(k)) for k in range(30)])
    drain(service)
    assert service._health.t_ns == 29 * 33_000_000


def test_a_garbled_device_fixation_does_not_silence_the_gaze(exchange, service):
    publish_all(exchange, [*INTRODUCTION.items(), (Stream.HEAD_IMAGE, head_image(1))])
    publish_all(exchange, [(Stream.DEVICE_FIXATION, b"\xff\xff")])
    drain(service)
    assert not service._has_device_fixations


def test_what_nobody_foresaw_is_told_and_the_next_images_begin_another_map(exchange, service):
    publish_all(exchange, [*INTRODUCTION.items(), (Stream.HEAD_IMAGE, head_image(1))])
    drain(service)
    service._mapping.head_frame = lambda _: 1 / 0
    publish_all(exchange, [(Stream.HEAD_IMAGE, head_image(k)) for k in (2, 3)])
    drain(service)
    assert service._health.level is Level.ERROR
    assert "head/image: unexpected ZeroDivisionError" in complaints(service)
    assert service._health.t_ns == 3 * 33_000_000
