"""Opens the native recording as a session."""

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from gazemap.errors import InputError
from gazemap.geometry.camera import Camera
from gazemap.session.camera_file import ImageSize, read_camera
from gazemap.session.depth import NO_DEPTH, DepthSource
from gazemap.session.frames import FrameSource, MissingFrames
from gazemap.session.mcap_frames import McapDepth, McapImages, McapVideo
from gazemap.session.mcap_read import McapFile, StoredMessage
from gazemap.session.recorded import RecordedSession
from gazemap.types.session import GazeSamples, ImuSamples, SessionData
from gazemap.wire import images, rig
from gazemap.wire.schemas import VIDEO
from gazemap.wire.streams import Stream

_IMAGE_STREAMS = frozenset(
    {Stream.HEAD_IMAGE, Stream.OVERHEAD_IMAGE, Stream.DEPTH, Stream.OVERHEAD_DEPTH}
)
_DECODERS: dict[Stream, Callable[[bytes], Any]] = {
    Stream.SESSION: rig.decode_session,
    Stream.TAGS: rig.decode_tags,
    Stream.GAZE: rig.decode_gaze,
    Stream.IMU: rig.decode_imu,
    Stream.DEVICE_FIXATION: rig.decode_device_fixation,
    Stream.BLINK: rig.decode_blink,
    Stream.EVENT: rig.decode_event,
    Stream.NARRATION: rig.decode_cue,
}
Row = TypeVar("Row")


@dataclass(slots=True)
class _Contents:
    """What one reading of the file found."""

    rows: dict[Stream, list[Any]] = field(default_factory=lambda: defaultdict(list))
    image_t_ns: dict[Stream, list[int]] = field(default_factory=lambda: defaultdict(list))
    videos: set[Stream] = field(default_factory=set)
    cameras: dict[Stream, Camera] = field(default_factory=dict)

    def take(self, message: StoredMessage) -> None:
        """Sort in one message; of an image only its time is kept."""
        stream = message.stream
        if stream in _IMAGE_STREAMS:
            is_video = message.schema_name == VIDEO.full_name
            if is_video:
                self.videos.add(stream)
                packet = images.decode_packet(message.payload, stream=stream)
                self.image_t_ns[stream].append(packet.t_ns)
            else:
                image = images.decode_coded_image(message.payload, stream=stream)
                self.image_t_ns[stream].append(image.t_ns)
        elif stream in (Stream.HEAD_CALIBRATION, Stream.OVERHEAD_CALIBRATION):
            self.cameras[stream] = images.decode_calibration(message.payload, stream=stream)
        elif stream in _DECODERS:
            self.rows[stream].append(_DECODERS[stream](message.payload))

    def first(self, stream: Stream) -> Any | None:  # noqa: ANN401  the stream's own record
        """Return a stream's first record, or None."""
        return self.rows[stream][0] if self.rows[stream] else None


def open_mcap(path: Path, *, camera: Path | None) -> RecordedSession:
    """Open a native recording; what follows the last whole chunk of a cut file is left out.

    Args:
        path: the file.
        camera: a camera file to use in place of the recorded head camera.

    Raises:
        InputError: if it is no recording, or lacks the head camera's calibration.
    """
    file = McapFile(path)
    contents = _Contents()
    for message in file.messages():
        contents.take(message)
    head = contents.cameras.get(Stream.HEAD_CALIBRATION)
    if head is None:
        raise InputError(
            "no calibration of the head camera in it",
            where=path,
            todo="record head/calibration, or import the recording again",
        )
    if camera is not None:
        head = read_camera(camera, size=ImageSize(width_px=head.width_px, height_px=head.height_px))
    overhead = contents.cameras.get(Stream.OVERHEAD_CALIBRATION)
    return RecordedSession(
        data=_session_data(contents, file),
        scene=_source(file, contents, stream=Stream.HEAD_IMAGE, camera=head),
        overhead=None
        if overhead is None or not contents.image_t_ns[Stream.OVERHEAD_IMAGE]
        else _source(file, contents, stream=Stream.OVERHEAD_IMAGE, camera=overhead),
        scene_depth=_depth(file, contents, stream=Stream.DEPTH),
        overhead_depth=_depth(file, contents, stream=Stream.OVERHEAD_DEPTH),
    )


def _source(file: McapFile, contents: _Contents, *, stream: Stream, camera: Camera) -> FrameSource:
    t_ns = tuple(sorted(set(contents.image_t_ns[stream])))
    if not t_ns:
        return MissingFrames(camera=camera, path=file.path)
    if stream in contents.videos:
        return McapVideo(file=file, stream=stream, camera=camera, t_ns=t_ns)
    in_order = tuple(_increasing(contents.image_t_ns[stream]))
    return McapImages(file=file, stream=stream, camera=camera, t_ns=in_order)


def _increasing(times: list[int]) -> list[int]:
    kept: list[int] = []
    for t_ns in times:
        if not kept or t_ns > kept[-1]:
            kept.append(t_ns)
    return kept


def _depth(file: McapFile, contents: _Contents, *, stream: Stream) -> DepthSource:
    t_ns = tuple(contents.image_t_ns[stream])
    return McapDepth(file=file, stream=stream, t_ns=t_ns) if t_ns else NO_DEPTH


def _session_data(contents: _Contents, file: McapFile) -> SessionData:
    rows = contents.rows
    info = contents.first(Stream.SESSION) or rig.SessionInfo(name=file.path.stem)
    gaze = _by_time(rows[Stream.GAZE], lambda row: row.t_ns)
    imu = _by_time(rows[Stream.IMU], lambda row: row.t_ns)
    fixations = tuple(_by_time(rows[Stream.DEVICE_FIXATION], lambda row: row.start_ns))
    has_fixations = info.has_device_fixations or bool(fixations)
    warnings = list(info.warnings)
    if file.is_cut:
        warnings.append(f"{file.path.name}: the file is cut off; read up to its last whole chunk")
    return SessionData(
        name=file.path.stem,
        gaze=GazeSamples.of(gaze) if gaze else None,
        fixations=fixations if has_fixations else None,
        blinks=tuple(_by_time(rows[Stream.BLINK], lambda row: row.start_ns)),
        events=tuple(_by_time(rows[Stream.EVENT], lambda row: row.t_ns)),
        imu=ImuSamples.of(imu) if imu else None,
        narration=tuple(_by_time(rows[Stream.NARRATION], lambda row: row.start_ns)),
        tags=contents.first(Stream.TAGS),
        wearer_heading_rad=info.wearer_heading_rad,
        info=info.info,
        warnings=tuple(warnings),
    )


def _by_time(rows: list[Row], time_of: Callable[[Row], int]) -> list[Row]:
    return sorted(rows, key=time_of)
