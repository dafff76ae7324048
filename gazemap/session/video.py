"""Video files, whose times come from the table beside them and never from a frame rate."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import av
import cv2
import numpy as np
from av.bitstream import BitStreamFilterContext
from av.container import InputContainer

from gazemap.errors import InputError
from gazemap.geometry.arrays import ImageArray
from gazemap.geometry.camera import Camera
from gazemap.session.camera_file import ImageSize, read_camera
from gazemap.session.table import read_table, times_ns
from gazemap.types.frame import Frame
from gazemap.wire.images import CodedImage, ImageFormat, VideoPacket

# Codecs whose packets decode without a container, and what makes them so.
ANNEX_B_FILTERS = {"h264": "h264_mp4toannexb", "hevc": "hevc_mp4toannexb"}
_TODO_CUT = "the file is cut off or damaged: copy or export it again"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class VideoFile:
    """A video with one time a frame."""

    camera: Camera
    t_ns: tuple[int, ...]
    path: Path

    def frames(self) -> Iterator[Frame]:
        """Yield the frames as BGR, or grey where the video is grey.

        Raises:
            InputError: where the video ends or breaks before its last frame.
        """
        index = 0
        try:
            with _open(self.path) as container:
                stream = container.streams.video[0]
                stream.thread_type = "AUTO"
                for index, picture in enumerate(container.decode(stream)):
                    if index >= len(self.t_ns):
                        break
                    yield self._frame(index, picture)
        except av.error.FFmpegError as error:
            raise unreadable(self.path, read=index, expected=len(self.t_ns)) from error
        if index + 1 < len(self.t_ns):
            raise unreadable(self.path, read=index + 1, expected=len(self.t_ns))

    def _frame(self, index: int, picture: av.VideoFrame) -> Frame:
        expected = ImageSize(width_px=self.camera.width_px, height_px=self.camera.height_px)
        got = ImageSize(width_px=picture.width, height_px=picture.height)
        if got != expected:
            raise InputError(
                f"frame {index} has {got} pixels, {expected} expected",
                where=self.path,
                todo="record at one size, or cut the video before it",
            )
        return Frame(index=index, t_ns=self.t_ns[index], image=picture_to_image(picture))

    def coded(self) -> Iterator[CodedImage | VideoPacket]:
        """Yield the video's own packets, or lossless images where packets cannot stand alone."""
        with _open(self.path) as container:
            codec = container.streams.video[0].codec_context.name
        if codec in ANNEX_B_FILTERS:
            return self._packets(codec)
        return (code_losslessly(frame) for frame in self.frames())

    def _packets(self, codec: str) -> Iterator[VideoPacket]:
        order = self._presentation_order()
        with _open(self.path) as container:
            stream = container.streams.video[0]
            to_annex_b = BitStreamFilterContext(ANNEX_B_FILTERS[codec], stream)
            for packet in container.demux(stream):
                for unit in to_annex_b.filter(packet if packet.size else None):
                    index = order[unit.pts]
                    yield VideoPacket(
                        index=index, t_ns=self.t_ns[index], codec=codec, data=bytes(unit)
                    )

    def _presentation_order(self) -> dict[int | None, int]:
        with _open(self.path) as container:
            stream = container.streams.video[0]
            stamps = sorted(packet.pts or 0 for packet in container.demux(stream) if packet.size)
        return {pts: index for index, pts in enumerate(stamps)}


def _open(path: Path) -> InputContainer:
    # What a damaged file says of itself need not be text.
    return av.open(path, metadata_errors="replace")


def picture_to_image(picture: av.VideoFrame) -> ImageArray:
    """Return a decoded picture as BGR (H, W, 3), or grey (H, W) where it is grey."""
    layout = "gray" if picture.format.name.startswith("gray") else "bgr24"
    return np.asarray(picture.to_ndarray(format=layout), dtype=np.uint8)


def code_losslessly(frame: Frame) -> CodedImage:
    """Return a frame as PNG."""
    _, coded = cv2.imencode(".png", frame.image)
    return CodedImage(
        index=frame.index, t_ns=frame.t_ns, image_format=ImageFormat.PNG, data=coded.tobytes()
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Extent:
    size: ImageSize
    frame_count: int


def open_video(path: Path, *, timestamps: Path, camera: Path) -> VideoFile:
    """Open a video with its times and its camera; nothing is decoded yet.

    Raises:
        InputError: if one of the three is missing or damaged, or they contradict one another.
    """
    if not timestamps.exists():
        raise InputError(
            "the video's timestamps are missing",
            where=timestamps,
            todo="export the recording with timestamps; they cannot be told from a frame rate",
        )
    t_ns = frame_times(timestamps)
    size = _check_count(path, t_ns=t_ns, timestamps=timestamps)
    return VideoFile(camera=read_camera(camera, size=size), t_ns=t_ns, path=path)


def checked_video(
    path: Path, *, t_ns: tuple[int, ...], camera: Camera, timestamps: Path
) -> VideoFile:
    """Return a video with a known camera, once its size and its count of frames are right."""
    size = _check_count(path, t_ns=t_ns, timestamps=timestamps)
    if size != ImageSize(width_px=camera.width_px, height_px=camera.height_px):
        raise InputError(
            f"{camera.width_px}x{camera.height_px} pixels expected, got {size}",
            where=path,
            todo="give a camera file of this resolution with --camera",
        )
    return VideoFile(camera=camera, t_ns=t_ns, path=path)


def _check_count(path: Path, *, t_ns: tuple[int, ...], timestamps: Path) -> ImageSize:
    """Return the size of a video that has one frame a time."""
    extent = _measure(path, expected=len(t_ns))
    if extent.frame_count < len(t_ns):
        raise unreadable(path, read=extent.frame_count, expected=len(t_ns))
    if extent.frame_count > len(t_ns):
        raise InputError(
            f"{len(t_ns)} rows for {extent.frame_count} frames of {path.name}",
            where=timestamps,
            todo="export both files again",
        )
    return extent.size


def frame_times(path: Path) -> tuple[int, ...]:
    """Return the times of a timestamps file, which increase from row to row."""
    table = read_table(path)
    t_ns, is_new = times_ns(table, "timestamp [ns]")
    if len(t_ns) == 0:
        raise InputError("no row in it", where=path, todo="export the recording again")
    if not is_new.all():
        row = int(np.flatnonzero(~is_new)[0])
        raise InputError(
            f"two frames at {t_ns[row]}",
            where=f"{path}, line {table.lines[row]}",
            todo="export the recording again",
        )
    return tuple(t_ns.tolist())


def _measure(path: Path, *, expected: int) -> _Extent:
    """Return the size and count of the frames that are there, from the container alone."""
    file_size = path.stat().st_size
    try:
        with _open(path) as container:
            if not container.streams.video:
                raise InputError("no video in it", where=path, todo="give the scene video")
            stream = container.streams.video[0]
            if not hasattr(stream, "width"):  # no codec of FFmpeg's
                raise unreadable(path, read=0, expected=expected)
            size = ImageSize(width_px=stream.width, height_px=stream.height)
            count = sum(
                1
                for packet in container.demux(stream)
                if packet.size and (packet.pos is None or packet.pos + packet.size <= file_size)
            )
    except av.error.FFmpegError as error:
        raise unreadable(path, read=0, expected=expected) from error
    return _Extent(size=size, frame_count=count)


def unreadable(path: Path, *, read: int, expected: int) -> InputError:
    """Return the error of a video that has fewer frames than times."""
    return InputError(f"{read} of {expected} frames can be read", where=path, todo=_TODO_CUT)
