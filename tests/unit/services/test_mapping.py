"""The mapping service on a bus in memory: a rig's streams come in any order."""

import numpy as np
import pytest

from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Pose
from gazemap.live import LiveMappingConfig
from gazemap.slam.live.config import LiveConfig
from gazemap.types.frame import Frame
from gazemap.types.session import LayoutTag, TagLayout
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
    frame = Frame(index=k, t_ns=k * 33_000_000, image=grey)
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


def test_a_broken_message_is_named_and_stops_nothing(exchange, service):
    bus = MemoryBus(exchange)
    for stream, payload in INTRODUCTION.items():
        bus.publish(stream, payload)
    bus.publish(Stream.TAGS, b"\xff no protobuf")
    bus.publish(Stream.HEAD_IMAGE, head_image(0))
    drain(service)
    assert service._health.level is Level.WARNING
    assert service._mapping is not None
