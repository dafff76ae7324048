"""Rays into the model: which face each meets, by Open3D, and the colour there."""

import ctypes
import functools
from types import ModuleType
from typing import NamedTuple

import numpy as np

from gazemap.geometry.arrays import IntArray
from gazemap.sim.hand import SKIN_BGR, HandMesh
from gazemap.sim.model import Model, Moment
from gazemap.sim.shading import Float32Array, Int32Array, Samples, Shutter, shade, turned
from gazemap.sim.surfaces import facing_light

NOTHING = -1
_NO_PRIMITIVE = 0xFFFFFFFF  # what Open3D says where a ray meets nothing


@functools.cache
def open3d() -> ModuleType:
    """Import Open3D, whose wheel looks for a libusb that slim systems lack."""
    import libusb_package

    ctypes.CDLL(str(libusb_package.get_library_path()), ctypes.RTLD_GLOBAL)
    import open3d as o3d

    return o3d


class Hits(NamedTuple):
    """What rays meet, arrays of length N: face, triangle, place in it (N, 2), distance."""

    face: Int32Array
    triangle: IntArray
    place: Float32Array
    far_m: Float32Array


class Caster:
    """The model at a moment, seen through a camera's shutter."""

    def __init__(self, model: Model, moment: Moment, shutter: Shutter) -> None:
        """Build the search tree of all triangles."""
        o3d = open3d()
        self._shutter, self._store = shutter, model.store
        self.geometry = model.at(moment)
        self._tree = o3d.t.geometry.RaycastingScene(nthreads=1)
        mesh = self.geometry.vertices, self.geometry.triangles
        self._tree.add_triangles(*(o3d.core.Tensor(part) for part in mesh))

    @property
    def hand_face(self) -> int:
        """The number by which hits on the hand go: one beyond the faces."""
        return len(self.geometry.faces.texture)

    def meet(self, ray_cam: Float32Array, row: Int32Array) -> Hits:
        """Return what rays (N, 3) in the camera's frame, of image rows (N,), meet first."""
        o3d = open3d()
        directions = turned(self._shutter.R_world_cam, ray_cam, row)
        rays = np.empty((len(row), 6), np.float32)
        rays[:, :3], rays[:, 3:] = self._shutter.p_world_cam[row], directions
        hits = self._tree.cast_rays(o3d.core.Tensor(rays), nthreads=1)
        triangle = hits["primitive_ids"].numpy().astype(np.int64)
        face = np.minimum(triangle // 2, self.hand_face).astype(np.int32)
        face[triangle == _NO_PRIMITIVE] = NOTHING
        places, far_m = hits["primitive_uvs"].numpy(), hits["t_hit"].numpy()
        return Hits(face=face, triangle=triangle, place=places, far_m=far_m)

    def colour(self, samples: Samples) -> Float32Array:
        """Return colours (N, 3), BGR, of rays whose faces are known; black on the hand."""
        geometry = self.geometry
        return np.asarray(
            shade(samples, self._shutter, geometry.faces, self._store, geometry.light)
        )

    def paint_hand(self, colours: Float32Array, hits: Hits) -> None:
        """Set the colours (N, 3) of those hits that are on the hand."""
        on_hand = hits.face == self.hand_face
        if self.geometry.hand is not None and on_hand.any():
            triangle = hits.triangle[on_hand] - 2 * self.hand_face
            colours[on_hand] = _skin(self.geometry.hand, triangle, hits.place[on_hand])


def _skin(hand: HandMesh, triangle: IntArray, place: Float32Array) -> Float32Array:
    """Return colours (N, 3) of points on the hand, of barycentric places (N, 2) in triangles."""
    corners = hand.normals_world[hand.triangles[triangle]]  # (N, 3, 3)
    weights = np.column_stack([1.0 - place.sum(axis=1), place])
    normal = np.einsum("nk,nkx->nx", weights, corners)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return np.asarray(facing_light(normal)[:, None] * SKIN_BGR, dtype=np.float32)
