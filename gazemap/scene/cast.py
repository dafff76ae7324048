"""Rays into the scene as it stood at a moment; Open3D's conventions end here."""

import ctypes
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeVar

import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, IntArray
from gazemap.scene.ray_order import MIN_RAYS, Float32Array, coherent_order
from gazemap.scene.surface import BOX_TRIANGLES, box_vertices
from gazemap.types.scene import Miss, ObjectState, SceneModel, SceneObject, SurfaceHit, SurfaceKind

_Values = TypeVar("_Values", FloatArray, IntArray, BoolArray)


@cache
def open3d() -> Any:  # noqa: ANN401 - the module itself; it has no types
    """Return Open3D; it wants libusb, which a package carries where the system lacks it."""
    import libusb_package

    ctypes.CDLL(str(libusb_package.get_library_path()), ctypes.RTLD_GLOBAL)
    import open3d as o3d

    return o3d


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RayHits:
    """Where N rays met the scene.

    Attributes:
        reach_m: (N,) distance along the ray; infinite for a miss.
        normals_world: (N, 3) unit, towards the origin; any where there is no hit.
        object_index: (N,) index into the model's objects; -1 for the surface.
        is_measured: (N,) whether what was met was measured beside the support, or filled in there.
    """

    reach_m: FloatArray
    normals_world: FloatArray
    object_index: IntArray
    is_measured: BoolArray

    @property
    def is_hit(self) -> BoolArray:
        """Which rays met anything (N,)."""
        return np.isfinite(self.reach_m)


class SceneCaster:
    """A scene that can be asked what rays meet: `SurfaceQuery`.

    The surface is indexed once; the boxes of the objects are cheap and indexed anew for each
    arrangement that is asked for.
    """

    def __init__(self, model: SceneModel) -> None:
        """Index the surface."""
        self._model = model
        self._surface = _raycasting_scene(
            [(model.background.vertices_world, model.background.triangles)]
        )
        vertices = model.background.vertices_world
        self._middle_world = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
        kinds, triangles = model.background.kinds, model.background.triangles
        self._is_measured = np.zeros(len(triangles), dtype=bool)
        if kinds is not None:
            self._is_measured = kinds[triangles[:, 0]] != SurfaceKind.SUPPORT
        self._arrangements: dict[tuple[int, ...], Any] = {}

    def cast(
        self, *, t_ns: int, origins_world: FloatArray, directions_world: FloatArray
    ) -> list[SurfaceHit | Miss]:
        """Return the first hit of each ray (N, 3), (N, 3 unit) in the scene as it stood at t_ns."""
        hits = self.cast_batch(
            t_ns=t_ns, origins_world=origins_world, directions_world=directions_world
        )
        return [
            self._hit(hits, i, origins_world[i] + hits.reach_m[i] * directions_world[i], t_ns)
            if np.isfinite(hits.reach_m[i])
            else Miss(reason="the ray meets no mapped surface")
            for i in range(len(origins_world))
        ]

    def _hit(self, hits: RayHits, i: int, point_world: FloatArray, t_ns: int) -> SurfaceHit:
        k, normal_world = int(hits.object_index[i]), hits.normals_world[i]
        thing = None if k < 0 else self._model.objects[k]
        if thing is None:
            measured = bool(hits.is_measured[i])
            sigma_m = self._model.measured_sigma_m if measured else self._model.surface_sigma_m
        else:
            sigma_m = _side_sigma_m(thing, t_ns, normal_world)
        return SurfaceHit(
            point_world=point_world,
            normal_world=normal_world,
            object_id=None if thing is None else thing.object_id,
            sigma_m=sigma_m,
        )

    def cast_batch(
        self, *, t_ns: int, origins_world: FloatArray, directions_world: FloatArray
    ) -> RayHits:
        """Return the first hits of many rays (N, 3), (N, 3 unit) as arrays."""
        rays = np.empty((len(origins_world), 6), dtype=np.float32)
        rays[:, :3], rays[:, 3:] = origins_world, directions_world
        if len(rays) < MIN_RAYS:
            return self._cast_in_order(t_ns, rays)
        order = coherent_order(rays, self._middle_world)
        hits = self._cast_in_order(t_ns, rays[order])
        return RayHits(
            reach_m=_put_back(hits.reach_m, order),
            normals_world=_put_back(hits.normals_world, order),
            object_index=_put_back(hits.object_index, order),
            is_measured=_put_back(hits.is_measured, order),
        )

    def _cast_in_order(self, t_ns: int, rays: Float32Array) -> RayHits:
        tensor = open3d().core.Tensor.from_numpy(rays)
        answer = self._surface.cast_rays(tensor)
        reach = answer["t_hit"].numpy().astype(np.float64)
        normals = answer["primitive_normals"].numpy().astype(np.float64)
        index = np.full(len(rays), -1, dtype=np.int64)
        triangle = answer["primitive_ids"].numpy()
        is_measured = np.zeros(len(rays), dtype=bool)
        met = np.isfinite(reach)
        is_measured[met] = self._is_measured[triangle[met]]
        boxes, owners = self._boxes(t_ns)
        if boxes is not None:
            near = boxes.cast_rays(tensor)
            box_reach = near["t_hit"].numpy()
            closer = box_reach < reach
            reach[closer] = box_reach[closer]
            normals[closer] = near["primitive_normals"].numpy()[closer]
            index[closer] = owners[near["geometry_ids"].numpy()[closer]]
        away = np.einsum("ij,ij->i", normals, rays[:, 3:]) > 0
        normals[away] *= -1
        return RayHits(
            reach_m=reach, normals_world=normals, object_index=index, is_measured=is_measured
        )

    def _boxes(self, t_ns: int) -> tuple[Any, IntArray]:
        standing = [(k, thing, thing.at(t_ns)) for k, thing in enumerate(self._model.objects)]
        here = [(k, thing, state) for k, thing, state in standing if state is not None]
        key = tuple(n for k, _, state in here for n in (k, state.t_ns))
        if key not in self._arrangements:
            meshes = [_box_mesh(thing, state) for _, thing, state in here]
            self._arrangements[key] = _raycasting_scene(meshes) if meshes else None
        return self._arrangements[key], np.array([k for k, _, _ in here], dtype=np.int64)


def _put_back(values: _Values, order: IntArray) -> _Values:
    back = np.empty_like(values)
    back[order] = values
    return back


def _side_sigma_m(thing: SceneObject, t_ns: int, normal_world: FloatArray) -> float:
    """Return how far a side of a box may lie from where it is thought to be, along its normal.

    The box's centre is uncertain, and so is by how much its sides lie away from it.
    """
    state = thing.at(t_ns)
    centre = 0.0 if state is None else float(normal_world @ state.cov_world @ normal_world)
    return float(np.sqrt(centre + (thing.size_sigma_m / 2) ** 2))


def _box_mesh(thing: SceneObject, state: ObjectState) -> tuple[FloatArray, IntArray]:
    return state.T_world_body.transform(box_vertices(thing.size_m)), BOX_TRIANGLES


def _raycasting_scene(meshes: list[tuple[FloatArray, IntArray]]) -> Any:  # noqa: ANN401 - untyped
    o3d = open3d()
    scene = o3d.t.geometry.RaycastingScene()
    for vertices, triangles in meshes:
        scene.add_triangles(
            o3d.core.Tensor.from_numpy(np.ascontiguousarray(vertices, dtype=np.float32)),
            o3d.core.Tensor.from_numpy(np.ascontiguousarray(triangles, dtype=np.uint32)),
        )
    return scene
