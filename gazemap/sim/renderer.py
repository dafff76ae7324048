"""Pictures of the simulated world: every pixel's ray is cast, edges by four rays a pixel."""

import ctypes
import functools
from dataclasses import dataclass
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.sim.hand import SKIN_BGR, HandMesh
from gazemap.sim.shading import (
    FaceTable,
    Float32Array,
    Int32Array,
    PictureStore,
    Samples,
    Shutter,
    face_table,
    joined,
    picture_store,
    shade,
    turned,
)
from gazemap.sim.shadows import ShadowPainter
from gazemap.sim.surfaces import Face, Room, box_corners, box_faces, facing_light
from gazemap.sim.tabletop import Block

_NO_PRIMITIVE = 0xFFFFFFFF  # what Open3D says where a ray meets nothing
_SUBPIXELS = ((-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Moment:
    """The world at one time: the blocks' centres (N, 3) in world, and the hand, if any."""

    centres_world: FloatArray
    hand: HandMesh | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Geometry:
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

    def at(self, moment: Moment) -> _Geometry:
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
        casters = [
            box_corners(matrix, block.size_m)
            for block, matrix in zip(self._blocks, matrices, strict=True)
        ]
        if moment.hand is not None:
            shift = np.uint32(len(vertices))
            vertices = np.concatenate([vertices, moment.hand.vertices_world.astype(np.float32)])
            triangles = np.concatenate([triangles, moment.hand.triangles + shift])
            casters += moment.hand.parts_world
        return _Geometry(
            faces=faces,
            vertices=vertices,
            triangles=triangles,
            hand=moment.hand,
            light=self._shadows.paint(casters),
        )


def _triangles(faces: list[Face]) -> tuple[Float32Array, NDArray[np.uint32]]:
    """Return vertices (4F, 3) and triangles (2F, 3): face f is triangles 2f and 2f + 1."""
    corner = np.array([f.corner_world for f in faces])
    across = np.array([f.across_world for f in faces])
    up = np.array([f.up_world for f in faces])
    vertices = np.stack([corner, corner + across, corner + across + up, corner + up], axis=1)
    start = 4 * np.arange(len(faces))[:, None, None]
    triangles = start + np.array([[0, 1, 2], [0, 2, 3]])
    return vertices.reshape(-1, 3).astype(np.float32), triangles.reshape(-1, 3).astype(np.uint32)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rendering:
    """A picture (H, W, 3), BGR 0..255, and the distances (H, W) along the rays in metres."""

    bgr: Float32Array
    far_m: Float32Array


class Renderer:
    """One camera before the model."""

    def __init__(self, camera: Camera, model: Model) -> None:
        """Prepare the rays of all pixels: through the centre, and four around it for edges."""
        self.camera, self._model = camera, model
        v, u = np.mgrid[0 : camera.height_px, 0 : camera.width_px]
        centre_px = np.column_stack([u.ravel(), v.ravel()]).astype(np.float64)
        self._row = v.ravel().astype(np.int32)
        self._rays = [
            camera.unproject(centre_px + offset).astype(np.float32)
            for offset in ((0.0, 0.0), *_SUBPIXELS)
        ]

    def render(self, moment: Moment, shutter: Shutter) -> Rendering:
        """Return the picture that the lens throws, before the sensor's noise."""
        scene = _Scene(self._model, moment, shutter)
        shape = (self.camera.height_px, self.camera.width_px)
        colours, face, far = scene.colour(self._rays[0], self._row)
        edge = np.flatnonzero(_edges(face.reshape(shape)))
        fine = [scene.colour(rays[edge], self._row[edge])[0] for rays in self._rays[1:]]
        colours[edge] = sum(fine) / np.float32(len(fine))
        return Rendering(bgr=colours.reshape(*shape, 3), far_m=far.reshape(shape))


@functools.cache
def open3d() -> ModuleType:
    """Import Open3D, whose wheel looks for a libusb that slim systems lack."""
    import libusb_package

    ctypes.CDLL(str(libusb_package.get_library_path()), ctypes.RTLD_GLOBAL)
    import open3d as o3d

    return o3d


def _edges(face: Int32Array) -> BoolArray:
    """Return which pixels (H, W) have a neighbour on another face."""
    edge = np.zeros(face.shape, dtype=np.bool_)
    across, down = face[:, 1:] != face[:, :-1], face[1:] != face[:-1]
    edge[:, 1:] |= across
    edge[:, :-1] |= across
    edge[1:] |= down
    edge[:-1] |= down
    return edge


class _Scene:
    """The model at a moment, in the form that casts rays."""

    def __init__(self, model: Model, moment: Moment, shutter: Shutter) -> None:
        o3d = open3d()
        self._shutter, self._store = shutter, model.store
        self._geometry = model.at(moment)
        self._caster = o3d.t.geometry.RaycastingScene(nthreads=1)
        mesh = self._geometry.vertices, self._geometry.triangles
        self._caster.add_triangles(*(o3d.core.Tensor(part) for part in mesh))

    def colour(
        self, ray_cam: Float32Array, row: Int32Array
    ) -> tuple[Float32Array, Int32Array, Float32Array]:
        """Return colours (N, 3), faces (N,) and distances (N,) of rays (N, 3) of image rows."""
        o3d = open3d()
        geometry = self._geometry
        origins = self._shutter.p_world_cam[row]
        directions = turned(self._shutter.R_world_cam, ray_cam, row)
        rays = np.concatenate([origins, directions], axis=1, dtype=np.float32)
        hits = self._caster.cast_rays(o3d.core.Tensor(rays))
        primitive = hits["primitive_ids"].numpy().astype(np.int64)
        count = len(geometry.faces.texture)
        face = np.minimum(primitive // 2, count).astype(np.int32)  # the hand is one more face
        face[primitive == _NO_PRIMITIVE] = -1
        samples = Samples(ray_cam=ray_cam, row=row, face=face)
        colours = shade(samples, self._shutter, geometry.faces, self._store, geometry.light)
        on_hand = face == count
        if geometry.hand is not None and on_hand.any():
            weights = hits["primitive_uvs"].numpy()[on_hand]
            colours[on_hand] = _skin(geometry.hand, primitive[on_hand] - 2 * count, weights)
        return colours, face, hits["t_hit"].numpy()


def _skin(hand: HandMesh, triangle: IntArray, weights: Float32Array) -> Float32Array:
    """Return colours (N, 3) of points on the hand given by barycentric weights (N, 2)."""
    corners = hand.normals_world[hand.triangles[triangle]]  # (N, 3, 3)
    full = np.column_stack([1.0 - weights.sum(axis=1), weights])
    normal = np.einsum("nk,nkx->nx", full, corners)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return np.asarray(facing_light(normal)[:, None] * SKIN_BGR, dtype=np.float32)
