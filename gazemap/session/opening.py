"""Opens a recording, whatever its format."""

from collections.abc import Callable
from enum import StrEnum
from pathlib import Path

from gazemap.errors import InputError
from gazemap.ports import Session
from gazemap.session.euroc import find_sensor, open_euroc
from gazemap.session.folder import open_folder
from gazemap.session.images import find_images, open_images
from gazemap.session.tum import open_tum

_MARKS_OF_A_SESSION = ("world_timestamps.csv", "gaze.csv", "scene_camera.json")


class SessionFormat(StrEnum):
    """The formats that are read."""

    NEON = "neon"
    TUM = "tum"
    EUROC = "euroc"
    IMAGES = "images"


def open_session(path: Path, *, camera: Path | None = None) -> Session:
    """Open a recording; nothing is decoded yet.

    Args:
        path: a session folder, a TUM or EuRoC folder, or a folder of images.
        camera: a camera file to use in place of the recording's own.

    Raises:
        InputError: if it is no recording, or a part of it cannot be used.
    """
    return open_as(path, session_format=detect_format(path), camera=camera)


def open_as(path: Path, *, session_format: SessionFormat, camera: Path | None) -> Session:
    """Open a recording of a known format."""
    return _openers()[session_format](path, camera)


def _openers() -> dict[SessionFormat, Callable[[Path, Path | None], Session]]:
    return {
        SessionFormat.NEON: lambda path, camera: open_folder(path, camera=camera),
        SessionFormat.TUM: lambda path, camera: open_tum(path, camera=camera),
        SessionFormat.EUROC: lambda path, camera: open_euroc(path, camera=camera),
        SessionFormat.IMAGES: lambda path, camera: open_images(path, camera=camera),
    }


def detect_format(path: Path) -> SessionFormat:
    """Tell a recording's format from what is in it."""
    if not path.exists():
        raise InputError("there is no such file or folder", where=path, todo="check the path")
    if not path.is_dir():
        raise InputError("a folder expected, this is a file", where=path, todo="give a recording")
    if (path / "rgb.txt").is_file():
        return SessionFormat.TUM
    if find_sensor(path) is not None:
        return SessionFormat.EUROC
    has_images = bool(find_images(path))
    if any(path.glob("*.mp4")) or (_has_marks(path) and not has_images):
        return SessionFormat.NEON
    if has_images:
        return SessionFormat.IMAGES
    raise InputError(
        "no recording in it: no video, rgb.txt, sensor.yaml or images",
        where=path,
        todo="give a session folder",
    )


def _has_marks(path: Path) -> bool:
    return any((path / name).is_file() for name in _MARKS_OF_A_SESSION)
