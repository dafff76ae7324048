"""Folders of images, with `scene_camera.json` in the folder or beside it."""

import itertools
from pathlib import Path

from gazemap.errors import InputError
from gazemap.session.camera_file import read_camera
from gazemap.session.frames import IMAGE_SUFFIXES, ImageFiles, image_size, read_image
from gazemap.session.recorded import RecordedSession
from gazemap.session.video import frame_times
from gazemap.types.session import SessionData

NOMINAL_STEP_NS = 33_333_333
# Names of this many digits are times in nanoseconds; shorter ones only count the images.
_TIME_DIGITS = 16


def find_images(folder: Path) -> tuple[Path, ...]:
    """Return the images of a folder in order of name."""
    return tuple(sorted(p for p in folder.iterdir() if p.suffix.lower() in IMAGE_SUFFIXES))


def open_images(path: Path, *, camera: Path | None) -> RecordedSession:
    """Open a folder of images, in order of name."""
    paths = find_images(path)
    if not paths:
        raise InputError("no image in it", where=path, todo="give a folder of images")
    beside = [folder / "scene_camera.json" for folder in (path, path.resolve().parent)]
    camera = camera or next((file for file in beside if file.is_file()), beside[0])
    t_ns, warnings = _times(path, paths)
    return RecordedSession(
        data=SessionData(name=path.resolve().name, warnings=warnings),
        scene=ImageFiles(
            camera=read_camera(camera, size=image_size(read_image(paths[0]))),
            t_ns=t_ns,
            paths=paths,
        ),
    )


def _times(folder: Path, paths: tuple[Path, ...]) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """Return the images' times: from world_timestamps.csv, or their names, or nominal ones."""
    listing = folder / "world_timestamps.csv"
    if listing.is_file():
        t_ns = frame_times(listing)
        if len(t_ns) != len(paths):
            raise InputError(
                f"{len(t_ns)} rows for {len(paths)} images", where=listing, todo="correct it"
            )
        return t_ns, ()
    stems = [path.stem for path in paths]
    if all(stem.isdecimal() and _TIME_DIGITS <= len(stem) < 20 for stem in stems):
        t_ns = tuple(int(stem) for stem in stems)
        if all(a < b for a, b in itertools.pairwise(t_ns)):
            return t_ns, ()
    nominal = tuple(i * NOMINAL_STEP_NS for i in range(len(paths)))
    return nominal, (f"{folder.name}: no times of the images; counted 30 a second from 0",)
