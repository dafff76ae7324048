"""Where frames come from, and the source that is a list of image files."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import cv2
import numpy as np

from gazemap.errors import InputError
from gazemap.geometry.arrays import ImageArray
from gazemap.geometry.camera import Camera
from gazemap.session.camera_file import ImageSize
from gazemap.types.frame import Frame
from gazemap.wire.images import CodedImage, ImageFormat, VideoPacket

_FORMATS = {
    ".png": ImageFormat.PNG,
    ".jpg": ImageFormat.JPEG,
    ".jpeg": ImageFormat.JPEG,
}
IMAGE_SUFFIXES = frozenset({".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".ppm"})


class FrameSource(Protocol):
    """One camera of a recording."""

    @property
    def camera(self) -> Camera:
        """The camera."""

    @property
    def t_ns(self) -> tuple[int, ...]:
        """The frames' times."""

    def frames(self) -> Iterator[Frame]:
        """Yield the frames in time order, decoded anew by each call."""

    def coded(self) -> Iterator[CodedImage | VideoPacket]:
        """Yield the frames as they are compressed: images in time order, or a video's packets."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ImageFiles:
    """One image file a frame."""

    camera: Camera
    t_ns: tuple[int, ...]
    paths: tuple[Path, ...]

    def frames(self) -> Iterator[Frame]:
        """Yield the images, grey where the file is grey."""
        for index, (t_ns, path) in enumerate(zip(self.t_ns, self.paths, strict=True)):
            image = read_image(path)
            size = image_size(image)
            if size != ImageSize(width_px=self.camera.width_px, height_px=self.camera.height_px):
                raise InputError(
                    f"{self.camera.width_px}x{self.camera.height_px} pixels expected, got {size}",
                    where=path,
                    todo="leave only images of one size",
                )
            yield Frame(index=index, t_ns=t_ns, image=image)

    def coded(self) -> Iterator[CodedImage]:
        """Yield the files' bytes."""
        for index, (t_ns, path) in enumerate(zip(self.t_ns, self.paths, strict=True)):
            image_format = _FORMATS.get(path.suffix.lower(), ImageFormat.OTHER)
            data = read_bytes(path)
            yield CodedImage(index=index, t_ns=t_ns, image_format=image_format, data=data)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MissingFrames:
    """A camera whose images the recording does not have."""

    camera: Camera
    path: Path
    t_ns: tuple[int, ...] = ()

    def frames(self) -> Iterator[Frame]:
        """Raise InputError: there is nothing to decode."""
        raise InputError(
            "the recording has no scene video", where=self.path, todo="export it with the video"
        )

    def coded(self) -> Iterator[CodedImage]:
        """Yield nothing."""
        return iter(())


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class JoinedFrames:
    """One camera whose recording is in several parts, in time order."""

    parts: tuple[FrameSource, ...]

    @property
    def camera(self) -> Camera:
        """The camera, the same in all parts."""
        return self.parts[0].camera

    @property
    def t_ns(self) -> tuple[int, ...]:
        """The frames' times."""
        return tuple(t_ns for part in self.parts for t_ns in part.t_ns)

    def frames(self) -> Iterator[Frame]:
        """Yield the frames of all parts, counted on."""
        for offset, part in self._offsets():
            for frame in part.frames():
                yield replace(frame, index=frame.index + offset)

    def coded(self) -> Iterator[CodedImage | VideoPacket]:
        """Yield what every part yields, counted on."""
        for offset, part in self._offsets():
            for each in part.coded():
                yield replace(each, index=each.index + offset)

    def _offsets(self) -> Iterator[tuple[int, FrameSource]]:
        offset = 0
        for part in self.parts:
            yield offset, part
            offset += len(part.t_ns)


def read_image(path: Path) -> ImageArray:
    """Return an image file as 8-bit grey (H, W) or BGR (H, W, 3)."""
    coded = np.frombuffer(read_bytes(path), dtype=np.uint8)
    image = cv2.imdecode(coded, cv2.IMREAD_ANYCOLOR) if coded.size else None
    if image is None:
        raise InputError("no image in it", where=path, todo="copy the file again")
    return np.asarray(image, dtype=np.uint8)


def read_bytes(path: Path) -> bytes:
    """Return a file's bytes."""
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", where=path, todo="add it") from error


def image_size(image: ImageArray) -> ImageSize:
    """Return the size of an image (H, W) or (H, W, 3)."""
    return ImageSize(width_px=image.shape[1], height_px=image.shape[0])
