"""Writes a recording as one MCAP file, with the bytes that the bus carries."""

import heapq
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from google.protobuf.descriptor import Descriptor
from mcap.writer import Writer

from gazemap.session.atomic import whole_file
from gazemap.session.frames import FrameSource
from gazemap.session.recorded import RecordedSession
from gazemap.types.session import SessionData
from gazemap.wire import images, rig
from gazemap.wire.images import CodedImage, VideoPacket
from gazemap.wire.schemas import SCHEMAS, VIDEO, schema_data
from gazemap.wire.streams import Stream

CHUNK_BYTES: Final = 1024 * 1024
PROFILE: Final = "gazemap"
_ENCODING: Final = "protobuf"


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """One message of a recording, at the time it would have been received."""

    log_ns: int
    stream: Stream
    payload: bytes
    schema: Descriptor


def write_mcap(session: RecordedSession, path: Path, *, chunk_bytes: int = CHUNK_BYTES) -> None:
    """Write a recording; the file is there whole or not at all.

    A video's packets are written as they are, in the order of decoding.

    Args:
        session: what to write.
        path: the file.
        chunk_bytes: how much is at stake if the file is cut off later.
    """
    with whole_file(path) as partial, partial.open("wb") as file:
        writer = McapWriter(Writer(file, chunk_size=chunk_bytes))
        for record in records(session):
            writer.write(record)
        writer.finish()


class McapWriter:
    """Writes records to the channels of their streams."""

    def __init__(self, writer: Writer) -> None:
        """Start the file."""
        self._writer = writer
        self._channels: dict[tuple[Stream, str], int] = {}
        self._writer.start(profile=PROFILE, library="gazemap")

    def write(self, record: Record) -> None:
        """Add one message."""
        known = (record.stream, record.schema.full_name)
        if known not in self._channels:
            self._channels[known] = self._register(record.stream, record.schema)
        self._writer.add_message(
            channel_id=self._channels[known],
            log_time=record.log_ns,
            publish_time=record.log_ns,
            data=record.payload,
        )

    def _register(self, stream: Stream, schema: Descriptor) -> int:
        number = self._writer.register_schema(schema.full_name, _ENCODING, schema_data(schema))
        return self._writer.register_channel(stream.value, _ENCODING, number)

    def finish(self) -> None:
        """Write what is left, and the index."""
        self._writer.finish()  # type: ignore[no-untyped-call]


def records(session: RecordedSession) -> Iterator[Record]:
    """Yield every message of a recording in the order of time, reading as it goes."""
    streams = [
        _head(session),
        _frames(session.scene, Stream.HEAD_IMAGE, "head"),
        *_data(session.data),
        _images(session.scene_depth.coded(), Stream.DEPTH, "head"),
        _images(session.overhead_depth.coded(), Stream.OVERHEAD_DEPTH, "overhead"),
    ]
    if session.overhead is not None:
        streams.append(_frames(session.overhead, Stream.OVERHEAD_IMAGE, "overhead"))
    return heapq.merge(*streams, key=lambda record: record.log_ns)


def _record(stream: Stream, log_ns: int, payload: bytes) -> Record:
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
    yield _record(Stream.SESSION, start_ns, rig.encode_session(info))
    head = images.encode_calibration(session.scene_camera, frame_id="head", t_ns=start_ns)
    yield _record(Stream.HEAD_CALIBRATION, start_ns, head)
    if session.overhead_camera is not None:
        overhead = images.encode_calibration(
            session.overhead_camera, frame_id="overhead", t_ns=start_ns
        )
        yield _record(Stream.OVERHEAD_CALIBRATION, start_ns, overhead)
    if data.tags is not None:
        yield _record(Stream.TAGS, start_ns, rig.encode_tags(data.tags))


def start_of(session: RecordedSession) -> int:
    """Return the time of a recording's first image or gaze sample."""
    times = [*session.scene_t_ns[:1], *session.overhead_t_ns[:1]]
    if session.data.gaze is not None:
        times.extend(session.data.gaze.t_ns[:1].tolist())
    return min(times, default=0)


def _data(data: SessionData) -> list[Iterator[Record]]:
    """The streams of small messages; a fixation and a cue are known when they have ended."""
    return [
        (_record(Stream.GAZE, s.t_ns, rig.encode_gaze(s)) for s in data.gaze or ()),
        (_record(Stream.IMU, s.t_ns, rig.encode_imu(s)) for s in data.imu or ()),
        (
            _record(Stream.DEVICE_FIXATION, f.end_ns, rig.encode_device_fixation(f))
            for f in sorted(data.fixations or (), key=lambda f: f.end_ns)
        ),
        (
            _record(Stream.BLINK, b.end_ns, rig.encode_blink(b))
            for b in sorted(data.blinks, key=lambda b: b.end_ns)
        ),
        (
            _record(Stream.EVENT, e.t_ns, rig.encode_event(e))
            for e in sorted(data.events, key=lambda e: e.t_ns)
        ),
        (
            _record(Stream.NARRATION, c.end_ns, rig.encode_cue(c))
            for c in sorted(data.narration, key=lambda c: c.end_ns)
        ),
    ]


def _frames(source: FrameSource, stream: Stream, frame_id: str) -> Iterator[Record]:
    log_ns = 0
    for each in source.coded():
        # Packets keep the order of decoding: none is logged before the one it is decoded after.
        log_ns = max(log_ns, each.t_ns)
        if isinstance(each, VideoPacket):
            payload = images.encode_packet(each, frame_id=frame_id)
            yield Record(log_ns=log_ns, stream=stream, payload=payload, schema=VIDEO)
        else:
            yield _record(stream, log_ns, images.encode_coded_image(each, frame_id=frame_id))


def _images(coded: Iterable[CodedImage], stream: Stream, frame_id: str) -> Iterator[Record]:
    for image in coded:
        payload = images.encode_coded_image(image, frame_id=frame_id)
        yield _record(stream, image.t_ns, payload)
