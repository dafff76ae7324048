"""TUM folders: `rgb.txt` with a camera file beside it."""

from pathlib import Path

from gazemap.session.camera_file import read_camera
from gazemap.session.depth import find_depth
from gazemap.session.folder import read_data
from gazemap.session.frames import ImageFiles, image_size, read_image
from gazemap.session.image_list import read_image_list
from gazemap.session.recorded import RecordedSession


def open_tum(path: Path, *, camera: Path | None) -> RecordedSession:
    """Open a TUM folder; the streams of a session folder are read where they are there."""
    t_ns, paths = read_image_list(path / "rgb.txt")
    size = image_size(read_image(paths[0]))
    return RecordedSession(
        data=read_data(path, scene_t_ns=t_ns),
        scene=ImageFiles(
            camera=read_camera(camera or path / "scene_camera.json", size=size),
            t_ns=t_ns,
            paths=paths,
        ),
        scene_depth=find_depth(path / "depth", listing=path / "depth.txt", frame_t_ns=t_ns),
    )
