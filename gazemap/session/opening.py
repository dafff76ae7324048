"""Opens a recording, whatever its format."""

from enum import StrEnum
from pathlib import Path
from typing import Final, Protocol

from gazemap.errors import InputError
from gazemap.session.euroc import find_sensor, open_euroc
from gazemap.session.folder import open_folder
from gazemap.session.images import find_images, open_images
from gazemap.session.mcap_session import open_mcap
from gazemap.session.neon_native import is_neon_native, open_neon_native
from gazemap.session.recorded import RecordedSession
from gazemap.session.tum import open_tum

_MARKS_OF_A_SESSION = ("world_timestamps.csv", "gaze.csv", "scene_camera.json")


class SessionFormat(StrEnum):
    """The formats that are read."""

    NEON = "neon"
    TUM = "tum"
    EUROC = "euroc"
    IMAGES = "images"
    MCAP = "mcap"


def _open_neon(path: Path, *, camera: Path | None) -> RecordedSession:
    """Open an export, which is the session folder, or what the phone itself wrote."""
    opened = open_neon_native if is_neon_native(path) else open_folder
    return opened(path, camera=camera)


class _Opener(Protocol):
    def __call__(self, path: Path, *, camera: Path | None) -> RecordedSession:
        """Open a recording of one format."""


_OPENERS: Final[dict[SessionFormat, _Opener]] = {
    SessionFormat.NEON: _open_neon,
    SessionFormat.TUM: open_tum,
    SessionFormat.EUROC: open_euroc,
    SessionFormat.IMAGES: open_images,
    SessionFormat.MCAP: open_mcap,
}


def open_session(path: Path, *, camera: Path | None = None) -> RecordedSession:
    """Open a recording; nothing is decoded yet.

    Args:
        path: a session folder, a native recording, a TUM, EuRoC or Neon phone's folder, or a
            folder of images.
        camera: a camera file to use in place of the recording's own.

    Raises:
        InputError: if it is no recording, or a part of it cannot be used.
    """
    return open_as(path, session_format=detect_format(path), camera=camera)


def open_as(path: Path, *, session_format: SessionFormat, camera: Path | None) -> RecordedSession:
    """Open a recording of a known format."""
    return _OPENERS[session_format](path, camera=camera)


def detect_format(path: Path) -> SessionFormat:
    """Tell a recording's format from what is in it."""
    if not path.exists():
        raise InputError("there is no such file or folder", where=path, todo="check the path")
    if not path.is_dir():
        return SessionFormat.MCAP
    if is_neon_native(path):
        return SessionFormat.NEON
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
