"""A fixation in the scene."""

from dataclasses import dataclass

from gazemap.geometry.arrays import FloatArray
from gazemap.types.scene import HitKind
from gazemap.types.session import Fixation


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fixation3D:
    """A fixation cast into the scene at its mid-time.

    Attributes:
        fixation: as detected, before any offset was taken out.
        scene_uv_px: (2,) the pixel that was cast, after the gaze offset was taken out.
        hit: what was met.
        point_world: (3,) metres, or None for no hit.
        cov_world: (3, 3) m^2, or None for no hit.
        object_id: the object that was met, or None.
        overhead_uv_px: (2,) its projection into the overhead camera, or None.
        reason: why there is no hit; empty where there is one.
        origin_world: (3,) the camera's centre from which it was cast, or None without a pose.
    """

    fixation: Fixation
    scene_uv_px: FloatArray
    hit: HitKind
    point_world: FloatArray | None
    cov_world: FloatArray | None
    object_id: str | None
    overhead_uv_px: FloatArray | None
    reason: str = ""
    origin_world: FloatArray | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class GazeOffset:
    """A session's constant angular gaze error: what is subtracted from azimuth and elevation.

    Attributes:
        azimuth_rad: to the right is positive.
        elevation_rad: up is positive.
        azimuth_sigma_rad: its standard deviation.
        elevation_sigma_rad: its standard deviation.
        is_applied: whether it was significant and was taken out.
    """

    azimuth_rad: float
    elevation_rad: float
    azimuth_sigma_rad: float
    elevation_sigma_rad: float
    is_applied: bool
