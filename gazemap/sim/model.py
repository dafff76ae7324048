"""The simulated world in the form that rays meet: faces with pictures, the hand, shadows."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gazemap.geometry.arrays import FloatArray, ImageArray
from gazemap.sim.hand import HandMesh
from gazemap.sim.shading import (
    FaceTable,
    Float32Array,
    PictureStore,
    face_table,
    picture_store,
)
from gazemap.sim.shadows import ShadowPainter
from gazemap.sim.surfaces import Face, Room, box_corners, box_faces
from gazemap.sim.tabletop import Block


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Moment:
    """The world at one time: the blocks' centres (N, 3) in world, and the hand, if any."""

    centres_world: FloatArray
    hand: HandMesh | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Geometry:
    """What rays meet: F faces as two triangles each, then the hand's triangles."""

    faces: FaceTable
    vertices: Float32Array
    triangles: NDArray[np.uint32]
    hand: HandMesh | None
    light: ImageArray


class Model:
    """The things that are drawn, whatever the camera."""

    def __init__(self, room: Room, blocks: tuple[Block, ...]) -> None:
        """Prepare all pictures and faces; the blocks stand where they do at the start."""
        self._blocks = blocks
        self._starts_world = np.array([block.start_world for block in blocks])
        first = len(room.pictures) - len(blocks)
        moving = [
            face
            for i, block in enumerate(blocks)
            for face in box_faces(block.T_world_body(block.start_world), block.size_m, (first + i,))
        ]
        faces = [*room.faces, *moving]
        self._faces_per_block = len(moving) // len(blocks)
        self.store: PictureStore = picture_store(room.pictures)
        self._faces = face_table(faces, room.pictures)
        self._vertices, self._triangles = _triangles(faces)
        self._shadows = ShadowPainter(room.casters)

    def at(self, moment: Moment) -> Geometry:
        """Return what rays meet at a moment: blocks keep their heading, so faces only shift."""
        shift = np.zeros_like(self._faces.corner)
        moved = (moment.centres_world - self._starts_world).repeat(self._faces_per_block, axis=0)
        shift[len(shift) - len(moved) :] = moved
        vertices = self._vertices + shift.repeat(4, axis=0).astype(np.float32)
        triangles = self._triangles
        if moment.hand is not None:
            count = np.uint32(len(vertices))
            vertices = np.concatenate([vertices, moment.hand.vertices_world.astype(np.float32)])
            triangles = np.concatenate([triangles, moment.hand.triangles + count])
        return Geometry(
            faces=self._faces._replace(corner=self._faces.corner + shift),
            vertices=vertices,
            triangles=triangles,
            hand=moment.hand,
            light=self._shadows.paint(self.bodies(moment)),
        )

    def bodies(self, moment: Moment) -> list[FloatArray]:
        """Return points (_, 3) in world around each convex body that moves at times."""
        boxes = [
            box_corners(block.T_world_body(centre), block.size_m)
            for block, centre in zip(self._blocks, moment.centres_world, strict=True)
        ]
        return boxes + (moment.hand.parts_world if moment.hand is not None else [])


def _triangles(faces: list[Face]) -> tuple[Float32Array, NDArray[np.uint32]]:
    """Return vertices (4F, 3) and triangles (2F, 3): face f is triangles 2f and 2f + 1."""
    corner = np.array([f.corner_world for f in faces])
    across = np.array([f.across_world for f in faces])
    up = np.array([f.up_world for f in faces])
    vertices = np.stack([corner, corner + across, corner + across + up, corner + up], axis=1)
    start = 4 * np.arange(len(faces))[:, None, None]
    triangles = start + np.array([[0, 1, 2], [0, 2, 3]])
    return vertices.reshape(-1, 3).astype(np.float32), triangles.reshape(-1, 3).astype(np.uint32)
