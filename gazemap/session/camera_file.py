"""Camera files: `scene_camera.json` in its older and newer forms."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from typing_extensions import override

from gazemap.errors import ConventionError, InputError
from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.camera import Camera, LensModel
from gazemap.session.documents import Document, numbers, read_json

_PINHOLE_NAMES = frozenset({"", "pinhole", "opencv", "radial", "rational"})
# A lens sits within a few per cent of the image's centre; a calibration that was made at 640x480
# and is used at 800x600 is off by ten.
_MAX_PRINCIPAL_OFFSET = 0.09


@dataclass(frozen=True, slots=True, kw_only=True)
class ImageSize:
    """Width and height of an image in pixels."""

    width_px: int
    height_px: int

    @override
    def __str__(self) -> str:
        return f"{self.width_px}x{self.height_px}"


def read_camera(path: Path, *, size: ImageSize) -> Camera:
    """Read the camera of images of the given size.

    Raises:
        InputError: if the file is missing, wrong, or was made for images of another size.
    """
    if not path.is_file():
        raise InputError(
            "the camera file is missing", where=path, todo="add it, or name one with --camera"
        )
    document = read_json(path)
    matrix = numbers(document, "camera_matrix", path=path)
    if matrix.size != 9:
        raise InputError(
            f"'camera_matrix' must be 3x3, got {matrix.size} numbers", where=path, todo="correct it"
        )
    camera = _camera(document, matrix.reshape(3, 3), size=size, path=path)
    check_size(camera, stated=_stated_size(document, path), path=path)
    return camera


def camera_in(document: Document, *, where: str) -> Camera:
    """Return the camera that a part of a file describes, with the size of its images.

    Raises:
        InputError: if it is wrong or names no size.
    """
    size = _stated_size(document, Path(where))
    if size is None:
        raise InputError("'width' and 'height' are missing", where=where, todo="add them")
    matrix = numbers(document, "camera_matrix", path=where)
    if matrix.size != 9:
        raise InputError(
            f"'camera_matrix' must be 3x3, got {matrix.size} numbers",
            where=where,
            todo="correct it",
        )
    return _camera(document, matrix.reshape(3, 3), size=size, path=Path(where))


def _camera(document: Document, K: FloatArray, *, size: ImageSize, path: Path) -> Camera:
    key = "distortion_coefficients" if "distortion_coefficients" in document else "dist_coefs"
    readout_s = document.get("readout_s")
    try:
        return Camera(
            width_px=size.width_px,
            height_px=size.height_px,
            K=K,
            distortion=numbers(document, key, path=path),
            lens=_lens(document, path),
            serial=str(document.get("serial_number") or ""),
            readout_s=None if readout_s is None else _readout_s(readout_s, path),
        )
    except ConventionError as error:
        raise InputError(str(error), where=path, todo="correct the camera file") from error


def _readout_s(value: object, path: Path) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < 1:
        raise InputError(
            f"'readout_s' must be seconds from the first row to the last, got {value!r}",
            where=path,
            todo="correct it or leave it out",
        )
    return float(value)


def _lens(document: Document, path: Path) -> LensModel:
    name = str(document.get("model") or "").lower()
    if name == "fisheye":
        return LensModel.FISHEYE
    if name in _PINHOLE_NAMES:
        return LensModel.PINHOLE
    raise InputError(
        f"'model' is '{name}'; 'pinhole' and 'fisheye' are known", where=path, todo="correct it"
    )


def _stated_size(document: Document, path: Path) -> ImageSize | None:
    """The image size that the file itself names; most files do not."""
    for key in ("resolution", "image_size"):
        if key in document:
            pair = numbers(document, key, path=path)
            if pair.size == 2:
                return ImageSize(width_px=int(pair[0]), height_px=int(pair[1]))
    for width, height in (("width", "height"), ("image_width", "image_height")):
        if width in document and height in document:
            pair = np.concatenate([numbers(document, key, path=path) for key in (width, height)])
            return ImageSize(width_px=int(pair[0]), height_px=int(pair[1]))
    return None


def check_size(camera: Camera, *, stated: ImageSize | None, path: Path) -> None:
    """Raise InputError if a camera was calibrated at another image size than its own.

    Where no size is stated, the principal point tells: it is near the centre of any whole image.
    """
    size = ImageSize(width_px=camera.width_px, height_px=camera.height_px)
    todo = f"use the calibration at {size}"
    if stated is not None and stated != size:
        raise InputError(
            f"the camera is for {stated} images, these are {size}", where=path, todo=todo
        )
    centre = camera.K[:2, 2] / (size.width_px, size.height_px)
    if stated is None and np.abs(centre - 0.5).max() > _MAX_PRINCIPAL_OFFSET:
        cx, cy = camera.K[:2, 2]
        raise InputError(
            f"the camera is for images of another resolution: its centre ({cx:.0f}, {cy:.0f}) "
            f"is not that of {size} images",
            where=path,
            todo=f'{todo}, or add "image_size": [{size.width_px}, {size.height_px}] if it is meant',
        )
