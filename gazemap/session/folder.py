"""The session folder: a Pupil Labs Neon export plus what Neon does not know."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TypeVar

from gazemap.errors import InputError
from gazemap.session import streams
from gazemap.session.depth import NO_DEPTH, find_depth
from gazemap.session.documents import Document, read_json
from gazemap.session.narration import read_narration
from gazemap.session.recorded import RecordedSession
from gazemap.session.tag_file import read_tags
from gazemap.session.video import VideoFile, open_video
from gazemap.types.session import SessionData


def open_folder(path: Path, *, camera: Path | None) -> RecordedSession:
    """Open a session folder; the videos are measured, not decoded.

    Args:
        path: the folder.
        camera: a camera file to use in place of scene_camera.json.
    """
    scene = open_video(
        scene_video(path),
        timestamps=path / "world_timestamps.csv",
        camera=camera or path / "scene_camera.json",
    )
    missing = _missing_beside_overhead(path)
    overhead = None if missing else _overhead(path)
    overhead_t_ns = overhead.t_ns if overhead else ()
    data = read_data(path, scene_t_ns=scene.t_ns)
    unused = tuple(f"overhead.mp4 is not used: there is no {name}" for name in missing)
    return RecordedSession(
        data=replace(data, warnings=(*data.warnings, *unused)),
        scene=scene,
        overhead=overhead,
        scene_depth=find_depth(path / "depth", listing=path / "depth.txt", frame_t_ns=scene.t_ns),
        overhead_depth=NO_DEPTH
        if overhead is None
        else find_depth(
            path / "overhead_depth",
            listing=path / "overhead_depth.txt",
            frame_t_ns=overhead_t_ns,
        ),
    )


def scene_video(folder: Path) -> Path:
    """Return scene.mp4, or the one other video of the folder."""
    named = folder / "scene.mp4"
    others = sorted(set(folder.glob("*.mp4")) - {folder / "overhead.mp4"})
    if named.is_file():
        return named
    if not others:
        raise InputError("the scene video is missing", where=named, todo="export it too")
    if len(others) > 1:
        names = ", ".join(other.name for other in others)
        raise InputError(
            f"more than one video: {names}", where=folder, todo="rename the scene's to scene.mp4"
        )
    return others[0]


def _missing_beside_overhead(path: Path) -> tuple[str, ...]:
    """Return what an overhead video, which a session need not have, lacks to be of use."""
    if not _is_there(path / "overhead.mp4"):
        return ()
    names = ("overhead_timestamps.csv", "overhead_camera.json")
    return tuple(name for name in names if not _is_there(path / name))


def _overhead(path: Path) -> VideoFile | None:
    video = path / "overhead.mp4"
    if not _is_there(video):
        return None
    return open_video(
        video, timestamps=path / "overhead_timestamps.csv", camera=path / "overhead_camera.json"
    )


Reading = TypeVar("Reading")


def read_data(path: Path, *, scene_t_ns: tuple[int, ...]) -> SessionData:
    """Read every stream of a folder that is there, but the images."""
    warnings: list[str] = []
    info = _if_there(path / "info.json", read_json) or {}
    gaze = _if_there(path / "gaze.csv", partial(streams.read_gaze, warn=warnings.append))
    if gaze is not None:
        streams.check_overlap(gaze, scene_t_ns=scene_t_ns, path=path / "gaze.csv")
    return SessionData(
        name=path.resolve().name,
        gaze=gaze,
        fixations=_if_there(
            path / "fixations.csv", partial(streams.read_fixations, warn=warnings.append)
        ),
        blinks=_if_there(path / "blinks.csv", streams.read_blinks) or (),
        events=_if_there(path / "events.csv", streams.read_events) or (),
        imu=_if_there(path / "imu.csv", partial(streams.read_imu, warn=warnings.append)),
        narration=_if_there(path / "narration.vtt", partial(read_narration, zero_ns=scene_t_ns[0]))
        or (),
        tags=_if_there(path / "tags.yaml", read_tags),
        wearer_heading_rad=heading_rad(info, path / "info.json"),
        info=info,
        warnings=tuple(warnings),
    )


def _if_there(path: Path, read: Callable[[Path], Reading]) -> Reading | None:
    return read(path) if _is_there(path) else None


def _is_there(path: Path) -> bool:
    """Return whether there is anything: a folder, or a link to nowhere, is not taken for absent."""
    return path.exists() or path.is_symlink()


def heading_rad(info: Document, path: Path) -> float:
    """Return the wearer's heading about z that info.json names; along +y is the default."""
    value = info.get("wearer_heading_rad")
    if value is None:
        return 0.0
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(
            f"'wearer_heading_rad' must be a number, got {value!r}", where=path, todo="correct it"
        )
    return float(value)
