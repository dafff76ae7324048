"""Fixations that were published are published again when the map under them moves."""

import time

import numpy as np
import pytest

from gazemap.live import LiveMappingConfig
from gazemap.slam.live.config import LiveConfig
from gazemap.types.frame import Frame
from gazemap.types.map import MapEventKind
from gazemap.types.session import Fixation, TagLayout
from gazemap.wire import images, mapping, rig
from gazemap.wire.images import ImageFormat
from gazemap.wire.rig import SessionInfo
from gazemap.wire.streams import Stream
from services.bus.base import Inbox
from services.bus.memory import Exchange, MemoryBus
from services.mapping import MappingService, MappingServiceConfig
from tests.planes import CAMERA, FRAME_NS, draw, room, swaying, tag

START_NS = 10**18
COUNT, TAGS_FROM = 85, 60
LOOKED_AT = {35: (280.0, 300.0), 45: (360.0, 260.0), 75: (320.0, 280.0)}
PLACES = [(0, [-0.45, 0.2, 0.0]), (3, [0.4, 0.25, 0.0]), (7, [0.05, -0.3, 0.0])]


def on_table(T_world_cam, uv_px):
    """Return where a pixel's ray meets the table z = 0 in the drawn world."""
    ray = T_world_cam.rotate(CAMERA.unproject(np.array([uv_px])))[0]
    return T_world_cam.t - T_world_cam.t[2] / ray[2] * ray


def look(n):
    mid_ns, (u_px, v_px) = START_NS + n * FRAME_NS, LOOKED_AT[n]
    fixation = Fixation(
        fixation_id=n, start_ns=mid_ns - 10**8, end_ns=mid_ns + 10**8, u_px=u_px, v_px=v_px
    )
    return rig.encode_device_fixation(fixation)


@pytest.fixture(scope="module")
def said():
    """Return the map events and fixations in the order in which the service published them.

    Tags that place the map come into sight only after the first looks were published.
    """
    exchange = Exchange()
    config = MappingServiceConfig(
        live=LiveMappingConfig(tracking=LiveConfig(in_process=True, lag_frames=3))
    )
    service, bus, heard = MappingService(MemoryBus(exchange), config), MemoryBus(exchange), Inbox()
    for stream in (Stream.MAP_EVENT, Stream.FIXATION):
        bus.subscribe(stream, heard)
    sheets, entries = zip(*(tag(k, centre, 0.09) for k, centre in PLACES), strict=True)
    info = SessionInfo(name="walk", has_device_fixations=True)
    bus.publish(Stream.SESSION, rig.encode_session(info))
    bus.publish(Stream.TAGS, rig.encode_tags(TagLayout(family="tag36h11", tags=entries)))
    bus.publish(Stream.HEAD_CALIBRATION, images.encode_calibration(CAMERA, frame_id="head"))
    for n, T_world_cam in enumerate(swaying(COUNT)):
        image = draw([*room(), *(sheets if n >= TAGS_FROM else ())], T_world_cam)
        frame = Frame(index=n, t_ns=START_NS + n * FRAME_NS, image=image)
        if n in LOOKED_AT:
            bus.publish(Stream.DEVICE_FIXATION, look(n))
        payload = images.encode_image(frame, frame_id="head", image_format=ImageFormat.PNG)
        bus.publish(Stream.HEAD_IMAGE, payload)
        while (message := service.inbox.get(timeout_s=0.0)) is not None:
            service.take(message)
        while service._mapping is None:  # it waits for an overhead camera, which there is none of
            service._begin_if_introduced()
            time.sleep(0.05)
    service._forget()
    messages = []
    while (message := heard.get(timeout_s=0.0)) is not None:
        decode = (
            mapping.decode_map_event
            if message.stream is Stream.MAP_EVENT
            else mapping.decode_fixation
        )
        messages.append(decode(message.payload))
    return messages


def test_a_map_that_moves_says_so_before_what_moved_with_it(said):
    kinds = [getattr(m, "kind", None) for m in said]
    moved = kinds.index(MapEventKind.RE_ANCHORED)
    assert said[moved].S_new_old is not None
    before = {m.fixation.fixation_id for m in said[:moved] if hasattr(m, "fixation")}
    after = {m.fixation.fixation_id for m in said[moved:] if hasattr(m, "fixation")}
    assert before == {35, 45}
    assert after == {35, 45, 75}


def test_what_is_published_last_lies_where_it_was_looked_at(said):
    last = {m.fixation.fixation_id: m for m in said if hasattr(m, "fixation")}
    poses = swaying(COUNT)
    for n, uv_px in LOOKED_AT.items():
        error_m = np.linalg.norm(last[n].point_world - on_table(poses[n], uv_px))
        assert 1e-6 < error_m < 0.012
