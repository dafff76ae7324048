"""A recording as the stream of messages that a rig would have sent, in the order of time."""

import heapq
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from google.protobuf.descriptor import Descriptor

from gazemap.session.frames import FrameSource
from gazemap.session.recorded import RecordedSession
from gazemap.types.session import SessionData
from gazemap.wire import images, rig
from gazemap.wire.images import CodedImage, VideoPacket
from gazemap.wire.schemas import SCHEMAS, VIDEO
from gazemap.wire.streams import Stream


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """One message of a recording, at the time it would have been received."""

    log_ns: int
    stream: Stream
    payload: bytes
    schema: Descriptor


FrameRecords = Callable[[FrameSource, Stream, str], Iterator[Record]]


def records(
    session: RecordedSession, *, frame_records: FrameRecords | None = None
) -> Iterator[Record]:
    """Yield every message of a recording in the order of time, reading as it goes.

    Args:
        session: the recording.
        frame_records: what makes messages of a camera (source, stream, name of its frame); as they
            are compressed by default.
    """
    of_frames = frame_records or coded_frame_records
    streams = [
        _head(session),
        of_frames(session.scene, Stream.HEAD_IMAGE, "head"),
        *_data(session.data),
        _images(session.scene_depth.coded(), Stream.DEPTH, "head"),
        _images(session.overhead_depth.coded(), Stream.OVERHEAD_DEPTH, "overhead"),
    ]
    if session.overhead is not None:
        streams.append(of_frames(session.overhead, Stream.OVERHEAD_IMAGE, "overhead"))
    return heapq.merge(*streams, key=lambda record: record.log_ns)


def record_of(stream: Stream, log_ns: int, payload: bytes) -> Record:
    """Return a message of a stream's usual schema."""
    return Record(log_ns=log_ns, stream=stream, payload=payload, schema=SCHEMAS[stream])


def _head(session: RecordedSession) -> Iterator[Record]:
    """What a reader needs before all else."""
    data, start_ns = session.data, start_of(session)
    info = rig.SessionInfo(
        name=data.name,
        wearer_heading_rad=data.wearer_heading_rad,
        has_device_fixations=data.fixations is not None,
        info=data.info,
        warnings=data.warnings,
    )
    yield record_of(Stream.SESSION, start_ns, rig.encode_session(info))
    head = images.encode_calibration(session.scene_camera, frame_id="head", t_ns=start_ns)
    yield record_of(Stream.HEAD_CALIBRATION, start_ns, head)
    if session.overhead_camera is not None:
        overhead = images.encode_calibration(
            session.overhead_camera, frame_id="overhead", t_ns=start_ns
        )
        yield record_of(Stream.OVERHEAD_CALIBRATION, start_ns, overhead)
    if data.tags is not None:
        yield record_of(Stream.TAGS, start_ns, rig.encode_tags(data.tags))


def start_of(session: RecordedSession) -> int:
    """Return the time of a recording's first image or gaze sample."""
    times = [*session.scene_t_ns[:1], *session.overhead_t_ns[:1]]
    if session.data.gaze is not None:
        times.extend(session.data.gaze.t_ns[:1].tolist())
    return min(times, default=0)


def _data(data: SessionData) -> list[Iterator[Record]]:
    """The streams of small messages; a fixation and a cue are known when they have ended."""
    return [
        (record_of(Stream.GAZE, s.t_ns, rig.encode_gaze(s)) for s in data.gaze or ()),
        (record_of(Stream.IMU, s.t_ns, rig.encode_imu(s)) for s in data.imu or ()),
        (
            record_of(Stream.DEVICE_FIXATION, f.end_ns, rig.encode_device_fixation(f))
            for f in sorted(data.fixations or (), key=lambda f: f.end_ns)
        ),
        (
            record_of(Stream.BLINK, b.end_ns, rig.encode_blink(b))
            for b in sorted(data.blinks, key=lambda b: b.end_ns)
        ),
        (
            record_of(Stream.EVENT, e.t_ns, rig.encode_event(e))
            for e in sorted(data.events, key=lambda e: e.t_ns)
        ),
        (
            record_of(Stream.NARRATION, c.end_ns, rig.encode_cue(c))
            for c in sorted(data.narration, key=lambda c: c.end_ns)
        ),
    ]


def coded_frame_records(source: FrameSource, stream: Stream, frame_id: str) -> Iterator[Record]:
    """Yield a camera's images or packets as they are compressed."""
    log_ns = 0
    for each in source.coded():
        # Packets keep the order of decoding: none is logged before the one it is decoded after.
        log_ns = max(log_ns, each.t_ns)
        if isinstance(each, VideoPacket):
            payload = images.encode_packet(each, frame_id=frame_id)
            yield Record(log_ns=log_ns, stream=stream, payload=payload, schema=VIDEO)
        else:
            yield record_of(stream, log_ns, images.encode_coded_image(each, frame_id=frame_id))


def _images(coded: Iterable[CodedImage], stream: Stream, frame_id: str) -> Iterator[Record]:
    for image in coded:
        payload = images.encode_coded_image(image, frame_id=frame_id)
        yield record_of(stream, image.t_ns, payload)
