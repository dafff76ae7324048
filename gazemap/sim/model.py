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
    joined,
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
        """Prepare all pictures and everything that stands still."""
        self._room, self._blocks = room, blocks
        self._pictures = room.pictures
        self.store: PictureStore = picture_store(room.pictures)
        self._still = face_table(room.faces, room.pictures)
        self._shadows = ShadowPainter(room.casters)

    def at(self, moment: Moment) -> Geometry:
        """Return what rays meet at a moment."""
        matrices = [
            block.T_world_body(centre)
            for block, centre in zip(self._blocks, moment.centres_world, strict=True)
        ]
        first = len(self._pictures) - len(self._blocks)
        moved = [
            face
            for i, (block, matrix) in enumerate(zip(self._blocks, matrices, strict=True))
            for face in box_faces(matrix, block.size_m, (first + i,))
        ]
        faces = joined(self._still, face_table(moved, self._pictures))
        vertices, triangles = _triangles([*self._room.faces, *moved])
        if moment.hand is not None:
            shift = np.uint32(len(vertices))
            vertices = np.concatenate([vertices, moment.hand.vertices_world.astype(np.float32)])
            triangles = np.concatenate([triangles, moment.hand.triangles + shift])
        return Geometry(
            faces=faces,
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
