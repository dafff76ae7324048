"""Cameras, frames, video packets and depth, in Foxglove's schemas."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Final

import cv2
import numpy as np
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.CompressedVideo_pb2 import CompressedVideo
from numpy.typing import NDArray

from gazemap.errors import InputError
from gazemap.geometry.arrays import ImageArray
from gazemap.geometry.camera import Camera, LensModel
from gazemap.types.frame import DepthFrame, Frame
from gazemap.wire.envelope import (
    SCHEMA_VERSION,
    matrix,
    parse_foxglove,
    refusing,
    time_ns,
    timestamp,
)
from gazemap.wire.generated import gazemap_streams_pb2 as pb

_FISHEYE: Final = "kannala_brandt"
_PLUMB_BOB: Final = "plumb_bob"
_RATIONAL: Final = "rational_polynomial"
# Foxglove's names of video codecs, and FFmpeg's.
_CODECS: Final = {"h264": "h264", "h265": "hevc", "vp9": "vp9", "av1": "av1"}
_FOXGLOVE_CODECS: Final = {ffmpeg: foxglove for foxglove, ffmpeg in _CODECS.items()}
_MAX_DEPTH_MM: Final = 65_535


class ImageFormat(StrEnum):
    """How an image is compressed."""

    JPEG = "jpeg"
    PNG = "png"
    # Other files of a folder of images, kept as they are.
    OTHER = "other"


@dataclass(frozen=True, slots=True, kw_only=True)
class CodedImage:
    """An image as its compressed bytes."""

    index: int
    t_ns: int
    image_format: ImageFormat
    data: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class VideoPacket:
    """One picture of a video as its compressed bytes, in the order of decoding.

    Attributes:
        index: position of the picture in the recording, from 0.
        t_ns: the picture's time; later packets may hold earlier pictures.
        codec: "h264" or another name that FFmpeg knows.
        data: the packet, Annex B where the codec has it.
    """

    index: int
    t_ns: int
    codec: str
    data: bytes


def encode_calibration(camera: Camera, *, frame_id: str, t_ns: int = 0) -> bytes:
    """Return the message of a camera; `frame_id` names its optical frame."""
    if camera.lens is LensModel.FISHEYE:
        model = _FISHEYE
    else:
        model = _RATIONAL if len(camera.distortion) > 5 else _PLUMB_BOB
    message = CameraCalibration(
        timestamp=timestamp(t_ns),
        frame_id=frame_id,
        width=camera.width_px,
        height=camera.height_px,
        distortion_model=model,
        D=camera.distortion,
        K=camera.K.ravel(),
        R=np.eye(3).ravel(),
        P=np.column_stack([camera.K, np.zeros(3)]).ravel(),
    )
    extra = pb.CalibrationExtra(
        version=SCHEMA_VERSION, serial=camera.serial, readout_s=camera.readout_s
    )
    return message.SerializeToString() + extra.SerializeToString()


def decode_calibration(payload: bytes, *, stream: str) -> Camera:
    """Read a camera."""
    message, extra = CameraCalibration(), pb.CalibrationExtra()
    parse_foxglove(message, extra, payload, stream=stream)
    known = (_FISHEYE, _PLUMB_BOB, _RATIONAL)
    if message.distortion_model not in known:
        raise InputError(
            f"lens model '{message.distortion_model}' is unknown; known: {', '.join(known)}",
            where=stream,
            todo="publish one of them",
        )
    is_fisheye = message.distortion_model == _FISHEYE
    with refusing(stream):
        return Camera(
            width_px=message.width,
            height_px=message.height,
            K=matrix(message.K, 3, name="K"),
            distortion=np.array(message.D, dtype=np.float64),
            lens=LensModel.FISHEYE if is_fisheye else LensModel.PINHOLE,
            serial=extra.serial,
            readout_s=extra.readout_s if extra.HasField("readout_s") else None,
        )


def encode_image(
    frame: Frame, *, frame_id: str, image_format: ImageFormat, jpeg_quality: int = 95
) -> bytes:
    """Return the message of a frame, compressed anew."""
    options = [cv2.IMWRITE_JPEG_QUALITY, jpeg_quality] if image_format is ImageFormat.JPEG else []
    _, coded = cv2.imencode(f".{image_format}", frame.image, options)
    image = CodedImage(
        index=frame.index, t_ns=frame.t_ns, image_format=image_format, data=coded.tobytes()
    )
    return encode_coded_image(image, frame_id=frame_id)


def encode_coded_image(image: CodedImage, *, frame_id: str) -> bytes:
    """Return the message of an image that is compressed already."""
    message = CompressedImage(
        timestamp=timestamp(image.t_ns),
        frame_id=frame_id,
        data=image.data,
        format=image.image_format.value,
    )
    extra = pb.ImageExtra(version=SCHEMA_VERSION, index=image.index)
    return message.SerializeToString() + extra.SerializeToString()


def decode_coded_image(payload: bytes, *, stream: str) -> CodedImage:
    """Read an image without decompressing it."""
    message, extra = CompressedImage(), pb.ImageExtra()
    parse_foxglove(message, extra, payload, stream=stream)
    # A CompressedVideo has its codec where an image has its frame.
    if message.frame_id in _CODECS:
        raise InputError(
            f"a packet of {message.frame_id} video, an image expected",
            where=stream,
            todo="publish single images, JPEG or PNG",
        )
    known = message.format in (ImageFormat.JPEG.value, ImageFormat.PNG.value)
    return CodedImage(
        index=extra.index,
        t_ns=time_ns(message.timestamp),
        image_format=ImageFormat(message.format) if known else ImageFormat.OTHER,
        data=message.data,
    )


def pixels_of(image: CodedImage, *, stream: str) -> ImageArray:
    """Decompress an image: grey (H, W) where it was sent grey, else BGR (H, W, 3)."""
    pixels = _pixels(image.data, cv2.IMREAD_ANYCOLOR)
    if pixels is None:
        raise InputError(
            f"no image in {len(image.data)} bytes of '{image.image_format}'",
            where=stream,
            todo="publish JPEG or PNG",
        )
    return np.asarray(pixels, dtype=np.uint8)


def decode_image(payload: bytes, *, stream: str) -> Frame:
    """Read a frame."""
    image = decode_coded_image(payload, stream=stream)
    return Frame(index=image.index, t_ns=image.t_ns, image=pixels_of(image, stream=stream))


def image_time_ns(payload: bytes, *, stream: str) -> int:
    """Read a frame's time alone; the image stays compressed."""
    message, extra = CompressedImage(), pb.ImageExtra()
    parse_foxglove(message, extra, payload, stream=stream)
    return time_ns(message.timestamp)


def _pixels(data: bytes, flag: int) -> NDArray[Any] | None:
    coded = np.frombuffer(data, dtype=np.uint8)
    return cv2.imdecode(coded, flag) if coded.size else None


def encode_packet(packet: VideoPacket, *, frame_id: str) -> bytes:
    """Return the message of one packet of a video."""
    message = CompressedVideo(
        timestamp=timestamp(packet.t_ns),
        frame_id=frame_id,
        data=packet.data,
        format=_FOXGLOVE_CODECS.get(packet.codec, packet.codec),
    )
    extra = pb.ImageExtra(version=SCHEMA_VERSION, index=packet.index)
    return message.SerializeToString() + extra.SerializeToString()


def decode_packet(payload: bytes, *, stream: str) -> VideoPacket:
    """Read one packet of a video."""
    message, extra = CompressedVideo(), pb.ImageExtra()
    parse_foxglove(message, extra, payload, stream=stream)
    return VideoPacket(
        index=extra.index,
        t_ns=time_ns(message.timestamp),
        codec=_CODECS.get(message.format, message.format),
        data=message.data,
    )


def encode_depth(frame: DepthFrame, *, frame_id: str) -> bytes:
    """Return the message of a depth image: a 16-bit PNG of millimetres, 0 where unknown."""
    depth_mm = np.rint(np.nan_to_num(frame.depth_m, nan=0.0) * 1000)
    _, coded = cv2.imencode(".png", np.clip(depth_mm, 0, _MAX_DEPTH_MM).astype(np.uint16))
    image = CodedImage(index=0, t_ns=frame.t_ns, image_format=ImageFormat.PNG, data=coded.tobytes())
    return encode_coded_image(image, frame_id=frame_id)


def decode_depth(payload: bytes, *, stream: str) -> DepthFrame:
    """Read a depth image."""
    message, extra = CompressedImage(), pb.ImageExtra()
    parse_foxglove(message, extra, payload, stream=stream)
    depth_mm = _pixels(message.data, cv2.IMREAD_UNCHANGED)
    if depth_mm is None or depth_mm.dtype != np.uint16 or depth_mm.ndim != 2:
        raise InputError("no 16-bit PNG of millimetres", where=stream, todo="publish depth as such")
    depth_m = depth_mm.astype(np.float32) / np.float32(1000)
    depth_m[depth_mm == 0] = np.nan
    return DepthFrame(t_ns=time_ns(message.timestamp), depth_m=depth_m)
