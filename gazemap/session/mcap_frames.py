"""Frames that lie in an MCAP file, as a video's packets or as images."""

from collections.abc import Iterator
from dataclasses import dataclass

import av
from av.codec import CodecContext
from av.video.codeccontext import VideoCodecContext

from gazemap.errors import InputError
from gazemap.geometry.camera import Camera
from gazemap.session.mcap_read import McapFile
from gazemap.session.video import picture_to_image, unreadable
from gazemap.types.frame import DepthFrame, Frame
from gazemap.wire import images
from gazemap.wire.images import CodedImage, VideoPacket
from gazemap.wire.streams import Stream


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class McapVideo:
    """A camera whose frames are a video's packets.

    Attributes:
        file: the file.
        stream: the camera's images.
        camera: the camera.
        t_ns: the times of the frames whose packets are there, increasing.
    """

    file: McapFile
    stream: Stream
    camera: Camera
    t_ns: tuple[int, ...]

    def coded(self) -> Iterator[VideoPacket]:
        """Yield the packets in the order of decoding."""
        for message in self.file.messages(self.stream):
            yield images.decode_packet(message.payload, stream=self.stream)

    def frames(self) -> Iterator[Frame]:
        """Yield the frames in time order.

        Raises:
            InputError: where the packets break off before the last frame.
        """
        index_at = {t_ns: index for index, t_ns in enumerate(self.t_ns)}
        count = 0
        try:
            for picture in self._pictures(index_at):
                index = picture.pts or 0
                yield Frame(index=index, t_ns=self.t_ns[index], image=picture_to_image(picture))
                count += 1
        except (av.error.FFmpegError, ValueError) as error:
            raise unreadable(self.file.path, read=count, expected=len(self.t_ns)) from error
        if count < len(self.t_ns):
            raise unreadable(self.file.path, read=count, expected=len(self.t_ns))

    def _pictures(self, index_at: dict[int, int]) -> Iterator[av.VideoFrame]:
        decoder: VideoCodecContext | None = None
        for packet in self.coded():
            if decoder is None:
                decoder = self._decoder(packet.codec)
            yield from decoder.decode(_unit(packet, pts=index_at[packet.t_ns]))
        if decoder is not None:
            yield from decoder.decode(None)

    def _decoder(self, codec: str) -> VideoCodecContext:
        try:
            decoder = CodecContext.create(codec, "r")
        except (av.error.FFmpegError, ValueError):
            decoder = None
        if not isinstance(decoder, VideoCodecContext):
            raise InputError(
                f"video codec '{codec}' is unknown", where=self.file.path, todo="record h264"
            )
        decoder.thread_type = "AUTO"
        return decoder


def _unit(packet: VideoPacket, *, pts: int) -> "av.Packet[av.stream.Stream]":
    """Return a packet whose bytes are FFmpeg's own.

    Bytes that Python owns are freed under the interpreter's lock, by whichever of the decoder's
    threads is done with them last. One that waits for the lock while this thread, which holds it,
    closes the decoder and waits for that thread would never end.
    """
    unit = av.Packet(len(packet.data))
    unit.update(packet.data)
    unit.pts = pts  # the presentation order is all a decoder wants of a time
    return unit


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class McapImages:
    """A camera whose frames are images; one that is not after the frame before it is left out."""

    file: McapFile
    stream: Stream
    camera: Camera
    t_ns: tuple[int, ...]

    def coded(self) -> Iterator[CodedImage]:
        """Yield the images as they are compressed, in time order."""
        last_ns = -1
        for message in self.file.messages(self.stream):
            image = images.decode_coded_image(message.payload, stream=self.stream)
            if image.t_ns > last_ns:
                last_ns = image.t_ns
                yield image

    def frames(self) -> Iterator[Frame]:
        """Yield the frames in time order."""
        for index, image in enumerate(self.coded()):
            pixels = images.pixels_of(image, stream=self.stream)
            if pixels.shape[:2] != (self.camera.height_px, self.camera.width_px):
                raise InputError(
                    f"{self.camera.width_px}x{self.camera.height_px} pixels expected, "
                    f"got {pixels.shape[1]}x{pixels.shape[0]}",
                    where=f"{self.file.path}, {self.stream}",
                    todo="give the calibration of these images",
                )
            yield Frame(index=index, t_ns=image.t_ns, image=pixels)


@dataclass(frozen=True, slots=True, kw_only=True)
class McapDepth:
    """Depth images of one camera."""

    file: McapFile
    stream: Stream
    t_ns: tuple[int, ...]

    def coded(self) -> Iterator[CodedImage]:
        """Yield the depth images as they are compressed."""
        for message in self.file.messages(self.stream):
            yield images.decode_coded_image(message.payload, stream=self.stream)

    def frames(self) -> Iterator[DepthFrame]:
        """Yield the depth images in time order."""
        for message in self.file.messages(self.stream):
            yield images.decode_depth(message.payload, stream=self.stream)
