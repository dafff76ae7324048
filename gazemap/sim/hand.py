"""The hand and the arm that carry things: simple round bodies, and the way they go."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gazemap.geometry.arrays import FloatArray
from gazemap.sim.tabletop import Demonstration

SKIN_BGR = np.array([118.0, 148.0, 204.0])
_REST_WORLD = np.array([0.30, -0.66, 0.10])
_ELBOW_WORLD = np.array([0.34, -0.80, 0.26])
_PALM_FROM_TIP = np.array([0.012, -0.035, 0.050])
_REACH_S, _RETURN_S = 0.95, 0.9
_ARC_M = 0.07
_SIDES, _RINGS = 20, 10


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HandMesh:
    """Hand and arm at a moment, in world.

    Attributes:
        vertices_world: (V, 3).
        normals_world: (V, 3) unit, of the smooth surface.
        triangles: (T, 3) indices of vertices.
        parts_world: vertices (_, 3) of each convex part.
    """

    vertices_world: FloatArray
    normals_world: FloatArray
    triangles: NDArray[np.uint32]
    parts_world: list[FloatArray]


def hand_at(demonstration: Demonstration, t_s: float) -> HandMesh:
    """Return the hand at a time, from the first frame on."""
    tip = _fingertips_world(demonstration, t_s)
    palm = tip + _PALM_FROM_TIP
    wrist = palm + 0.06 * _unit(_ELBOW_WORLD - palm)
    parts = [
        _ball(palm, 0.036),
        _tube(palm, wrist, (0.033, 0.027)),
        _tube(wrist, _ELBOW_WORLD + 0.1 * _unit(_ELBOW_WORLD - wrist), (0.027, 0.046)),
    ]
    for x in (-0.026, 0.0, 0.026):
        knuckle = palm + np.array([x, 0.018, -0.004])
        end = tip + np.array([0.8 * x, 0.012, 0.004])
        parts += [_tube(knuckle, end, (0.011, 0.008)), _ball(end, 0.008)]
    return _assembled(parts)


def _fingertips_world(demonstration: Demonstration, t_s: float) -> FloatArray:
    """Return where the fingers hold (3,): at rest, reaching, on the carried thing, returning."""
    for carry in demonstration.carries:
        grip = np.array([0.0, 0.0, demonstration.blocks[carry.block].size_m[2] * 0.35])
        if carry.lift_s - _REACH_S < t_s < carry.lift_s:
            part = (t_s - carry.lift_s + _REACH_S) / (_REACH_S - 0.1)
            return _swing(_REST_WORLD, carry.from_world + grip, part)
        if carry.lift_s <= t_s <= carry.release_s + 0.1:
            return np.asarray(carry.centre_world(t_s) + grip)
        if carry.release_s < t_s < carry.release_s + _RETURN_S + 0.1:
            part = (t_s - carry.release_s - 0.1) / _RETURN_S
            return _swing(carry.to_world + grip, _REST_WORLD, part)
    return _REST_WORLD


def _swing(start: FloatArray, end: FloatArray, part: float) -> FloatArray:
    a = min(max(part, 0.0), 1.0)
    s = a**3 * (10.0 - 15.0 * a + 6.0 * a * a)
    way: FloatArray = start * (1.0 - s) + end * s
    return np.asarray(way + np.array([0.0, 0.0, _ARC_M * np.sin(np.pi * s)]))


def _unit(vector: FloatArray) -> FloatArray:
    unit: FloatArray = vector / np.linalg.norm(vector)
    return unit


_Part = tuple[FloatArray, FloatArray, NDArray[np.uint32]]


def _tube(start: FloatArray, end: FloatArray, radii_m: tuple[float, float]) -> _Part:
    """Return an open tapered tube: vertices, normals, triangles."""
    axis = _unit(end - start)
    aside = _unit(np.cross(axis, [0.3, 0.1, 1.0]))
    angle = np.linspace(0.0, 2.0 * np.pi, _SIDES, endpoint=False)
    ring = np.cos(angle)[:, None] * aside + np.sin(angle)[:, None] * np.cross(axis, aside)
    vertices = np.concatenate([start + radii_m[0] * ring, end + radii_m[1] * ring])
    return vertices, np.concatenate([ring, ring]), _lattice(2)


def _ball(centre: FloatArray, radius_m: float) -> _Part:
    polar = np.linspace(0.0, np.pi, _RINGS)[:, None]
    angle = np.linspace(0.0, 2.0 * np.pi, _SIDES, endpoint=False)
    x, y = np.sin(polar) * np.cos(angle), np.sin(polar) * np.sin(angle)
    normals = np.stack([x, y, np.broadcast_to(np.cos(polar), x.shape)], axis=2).reshape(-1, 3)
    return centre + radius_m * normals, normals, _lattice(_RINGS)


def _lattice(rings: int) -> NDArray[np.uint32]:
    """Return the triangles between neighbouring rings of `_SIDES` vertices each."""
    here = np.arange(_SIDES * (rings - 1)).reshape(rings - 1, _SIDES)
    following = np.roll(here, -1, axis=1)
    lower = np.stack([here, following, following + _SIDES], axis=2)
    upper = np.stack([here, following + _SIDES, here + _SIDES], axis=2)
    return np.concatenate([lower, upper]).reshape(-1, 3).astype(np.uint32)


def _assembled(parts: list[_Part]) -> HandMesh:
    starts = np.cumsum([0, *(len(vertices) for vertices, _, _ in parts)])
    shifted = [tri + np.uint32(s) for (_, _, tri), s in zip(parts, starts, strict=False)]
    return HandMesh(
        vertices_world=np.concatenate([part[0] for part in parts]),
        normals_world=np.concatenate([part[1] for part in parts]),
        triangles=np.concatenate(shifted),
        parts_world=[part[0] for part in parts],
    )
