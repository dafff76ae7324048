"""Where frames come from, and the source that is a list of image files."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import cv2
import numpy as np

from gazemap.errors import InputError
from gazemap.geometry.arrays import ImageArray
from gazemap.geometry.camera import Camera
from gazemap.session.camera_file import ImageSize
from gazemap.types.frame import Frame

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


def read_image(path: Path) -> ImageArray:
    """Return an image file as 8-bit grey (H, W) or BGR (H, W, 3)."""
    try:
        coded = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", where=path, todo="add it") from error
    image = cv2.imdecode(coded, cv2.IMREAD_ANYCOLOR) if coded.size else None
    if image is None:
        raise InputError("no image in it", where=path, todo="copy the file again")
    return np.asarray(image, dtype=np.uint8)


def image_size(image: ImageArray) -> ImageSize:
    """Return the size of an image (H, W) or (H, W, 3)."""
    return ImageSize(width_px=image.shape[1], height_px=image.shape[0])
