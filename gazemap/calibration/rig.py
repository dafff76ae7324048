"""A rig's calibration: a dated folder of `calib/`, described in calib/SCHEMA.md."""

from dataclasses import dataclass, field
from pathlib import Path

from gazemap.config import load_config
from gazemap.geometry.camera import Camera
from gazemap.session.camera_file import ImageSize, read_camera
from gazemap.session.tag_file import read_tags
from gazemap.types.session import TagLayout


@dataclass(frozen=True, slots=True, kw_only=True)
class RigCamera:
    """One camera of rig.toml: its file and the size of its images."""

    file: Path = Path("scene_camera.json")
    width_px: int = 0
    height_px: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class RigFile:
    """rig.toml; files are relative to it."""

    name: str = "rig"
    date: str = ""
    wearer_heading_rad: float = 0.0
    tags: Path | None = None
    head_camera: RigCamera = field(default_factory=RigCamera)
    overhead_camera: RigCamera | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rig:
    """What is known of a rig before any recording."""

    name: str
    wearer_heading_rad: float
    head_camera: Camera
    overhead_camera: Camera | None
    layout: TagLayout | None


def load_rig(folder: Path) -> Rig:
    """Read a calibration folder.

    Raises:
        ConfigError: if rig.toml is missing or wrong.
        InputError: if a file that it names is missing or wrong.
    """
    described = load_config(RigFile, folder / "rig.toml")
    overhead = described.overhead_camera
    return Rig(
        name=described.name,
        wearer_heading_rad=described.wearer_heading_rad,
        head_camera=_camera(folder, described.head_camera),
        overhead_camera=None if overhead is None else _camera(folder, overhead),
        layout=None if described.tags is None else read_tags(folder / described.tags),
    )


def _camera(folder: Path, described: RigCamera) -> Camera:
    size = ImageSize(width_px=described.width_px, height_px=described.height_px)
    return read_camera(folder / described.file, size=size)
