"""Registered depth images, read one at a time."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import cv2
import numpy as np

from gazemap.errors import InputError
from gazemap.session.frames import read_bytes
from gazemap.session.image_list import read_image_list
from gazemap.types.frame import DepthFrame
from gazemap.wire.images import CodedImage, ImageFormat

MILLIMETRES_PER_M = 1000.0


class DepthSource(Protocol):
    """Depth images registered to one camera."""

    @property
    def t_ns(self) -> tuple[int, ...]:
        """Their times."""

    def frames(self) -> Iterator[DepthFrame]:
        """Yield the depth images in time order."""

    def coded(self) -> Iterator[CodedImage]:
        """Yield the depth images as they are compressed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DepthFiles:
    """One 16-bit PNG a depth image, in millimetres unless `units_per_m` says otherwise."""

    t_ns: tuple[int, ...] = ()
    paths: tuple[Path, ...] = ()
    units_per_m: float = MILLIMETRES_PER_M

    def frames(self) -> Iterator[DepthFrame]:
        """Yield the depth images in time order."""
        for t_ns, path in zip(self.t_ns, self.paths, strict=True):
            yield DepthFrame(t_ns=t_ns, depth_m=_read_depth(path, self.units_per_m))

    def coded(self) -> Iterator[CodedImage]:
        """Yield PNGs in millimetres: the files' bytes where they are such already."""
        for index, (t_ns, path) in enumerate(zip(self.t_ns, self.paths, strict=True)):
            data = read_bytes(path)
            if self.units_per_m != MILLIMETRES_PER_M:
                depth_mm = np.nan_to_num(_read_depth(path, self.units_per_m)) * MILLIMETRES_PER_M
                data = cv2.imencode(".png", np.rint(depth_mm).astype(np.uint16))[1].tobytes()
            yield CodedImage(index=index, t_ns=t_ns, image_format=ImageFormat.PNG, data=data)


NO_DEPTH = DepthFiles()


def find_depth(folder: Path, *, listing: Path, frame_t_ns: tuple[int, ...]) -> DepthFiles:
    """Return the depth images of a camera.

    Args:
        folder: where the PNGs are; there may be none.
        listing: a TUM list of time and file; without it there is one PNG a frame, in order of name.
        frame_t_ns: the times of the camera's frames.
    """
    if listing.is_file():
        times, paths = read_image_list(listing)
        return DepthFiles(t_ns=times, paths=paths)
    if not folder.is_dir():
        return NO_DEPTH
    paths = tuple(sorted(folder.glob("*.png")))
    if len(paths) != len(frame_t_ns):
        raise InputError(
            f"{len(paths)} depth images for {len(frame_t_ns)} frames",
            where=folder,
            todo=f"add {listing.name} with a time for each, or one image a frame",
        )
    return DepthFiles(t_ns=frame_t_ns, paths=paths)


def _read_depth(
    path: Path, units_per_m: float
) -> "np.ndarray[tuple[int, int], np.dtype[np.float32]]":
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED) if path.is_file() else None
    if image is None or image.dtype != np.uint16 or image.ndim != 2:
        raise InputError(
            "a 16-bit grey PNG of millimetres expected", where=path, todo="add or correct it"
        )
    depth_m = image.astype(np.float32) / np.float32(units_per_m)
    depth_m[image == 0] = np.nan
    return depth_m
