"""TUM folders: `rgb.txt` with a camera file beside it."""

from dataclasses import replace
from pathlib import Path

from gazemap.session.camera_file import read_camera
from gazemap.session.depth import find_depth
from gazemap.session.folder import read_data
from gazemap.session.frames import ImageFiles, image_size, read_image
from gazemap.session.image_list import read_image_list
from gazemap.session.recorded import RecordedSession

# What TUM's RGB-D benchmark has in place of millimetres.
_BENCHMARK_UNITS_PER_M = 5000.0


def open_tum(path: Path, *, camera: Path | None) -> RecordedSession:
    """Open a TUM folder; the streams of a session folder are read where they are there."""
    t_ns, paths = read_image_list(path / "rgb.txt")
    size = image_size(read_image(paths[0]))
    depth = find_depth(path / "depth", listing=path / "depth.txt", frame_t_ns=t_ns)
    if _is_of_the_benchmark(path / "depth.txt"):
        depth = replace(depth, units_per_m=_BENCHMARK_UNITS_PER_M)
    return RecordedSession(
        data=read_data(path, scene_t_ns=t_ns),
        scene=ImageFiles(
            camera=read_camera(camera or path / "scene_camera.json", size=size),
            t_ns=t_ns,
            paths=paths,
        ),
        scene_depth=depth,
    )


def _is_of_the_benchmark(listing: Path) -> bool:
    """Return whether a list of depth images begins as those of TUM's RGB-D benchmark do."""
    if not listing.is_file():
        return False
    with listing.open(encoding="utf-8", errors="replace") as lines:
        return next(lines, "").startswith("# depth maps")
