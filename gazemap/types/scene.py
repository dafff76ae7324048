"""The scene: surface, objects and where a ray meets them."""

from dataclasses import dataclass
from enum import IntEnum, StrEnum

import numpy as np

from gazemap.geometry.arrays import FloatArray, ImageArray, IntArray
from gazemap.geometry.pose import Body, Overhead, Pose, World


class SurfaceKind(IntEnum):
    """How a part of the surface is known."""

    SUPPORT = 0  # the plane on which things stand
    MEASURED = 1  # depth in which views agree, or of depth images
    FITTED = 2  # a plane between measured parts, where there was nothing to compare
    BOX = 3  # a side of an object


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mesh:
    """A triangle mesh in world.

    Attributes:
        vertices_world: (V, 3) metres.
        triangles: (F, 3) vertex indices.
        colours: (V, 3) uint8 RGB.
        kinds: (V,) uint8 of `SurfaceKind`, or None where it was not handed on.
    """

    vertices_world: FloatArray
    triangles: IntArray
    colours: ImageArray
    kinds: ImageArray | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ObjectState:
    """Where an object came to rest: from t_ns on it stands at T_world_body, until it is carried.

    Attributes:
        t_ns: when it came to rest (the session's start for the first).
        left_ns: when it was taken away, or None while it still stands there.
        cov_world: covariance (3, 3) of the centre, m^2.
    """

    t_ns: int
    left_ns: int | None
    T_world_body: Pose[World, Body]
    cov_world: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SceneObject:
    """One thing on the table.

    Attributes:
        object_id: "object-N".
        size_m: extents (3,) of its box in its own frame, z up.
        track: its resting places in time order, at least one.
        mean_bgr: (3,) mean colour, for pictures.
        size_sigma_m: standard deviation of each extent.
    """

    object_id: str
    size_m: FloatArray
    track: tuple[ObjectState, ...]
    mean_bgr: FloatArray
    size_sigma_m: float = 0.001

    def at(self, t_ns: int) -> ObjectState | None:
        """Return the resting place at a time; None while it is carried or not yet there."""
        last = None
        for state in self.track:
            if state.t_ns <= t_ns:
                last = state
        if last is None or (last.left_ns is not None and t_ns >= last.left_ns):
            return None
        return last


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SceneModel:
    """What is known of the scene.

    Attributes:
        mesh: the surface as it stood at the start, objects included.
        background: the surface without the objects, into which rays are cast beside their boxes.
        objects: the things on the table with their resting places.
        T_world_overhead: the overhead camera's pose, or None without one.
        surface_sigma_m: standard deviation of the support along its normal.
        measured_sigma_m: the same of what was measured beside it.
    """

    mesh: Mesh
    background: Mesh
    objects: tuple[SceneObject, ...]
    T_world_overhead: Pose[World, Overhead] | None
    surface_sigma_m: float
    measured_sigma_m: float = 0.01


class HitKind(StrEnum):
    """What a gaze ray met."""

    SURFACE = "surface"
    OBJECT = "object"
    NONE = "none"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SurfaceHit:
    """The first surface point of a ray.

    Attributes:
        point_world: (3,) metres.
        normal_world: (3,) unit, towards the ray's origin.
        object_id: the object that was met, or None for the surface.
        sigma_m: standard deviation of the surface along its normal there.
    """

    point_world: FloatArray
    normal_world: FloatArray
    object_id: str | None
    sigma_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Miss:
    """A ray that meets nothing; `reason` says why."""

    reason: str


def yaw_rad(T_world_body: Pose[World, Body]) -> float:
    """Return the heading of a body about z in radians."""
    return float(np.arctan2(T_world_body.R[1, 0], T_world_body.R[0, 0]))
