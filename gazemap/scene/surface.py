"""Meshes of the table and of boxes."""

from dataclasses import replace

import numpy as np

from gazemap.geometry.arrays import FloatArray, ImageArray, IntArray
from gazemap.scene.crops import PosedCamera, as_bgr
from gazemap.types.frame import Frame
from gazemap.types.scene import Mesh, SceneObject, SurfaceKind

_TABLE_RGB = np.array([150, 150, 150], dtype=np.uint8)
_STEP_M = 0.004
_PAINT_PERIOD_NS = 1_000_000_000
_SIGNS = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]) / 2
# Two triangles a side, wound so that normals point outwards.
BOX_TRIANGLES: IntArray = np.array(
    [
        [0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
        [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5],
    ]
)  # fmt: skip


def table_mesh(outline_xy: FloatArray, *, step_m: float = _STEP_M) -> Mesh:
    """Return a flat grey grid at z = 0 between opposite corners (2, 2)."""
    low, high = outline_xy
    counts = np.maximum(np.ceil((high - low) / step_m).astype(int), 1) + 1
    x, y = (np.linspace(low[k], high[k], counts[k]) for k in (0, 1))
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    corner = np.arange(counts[1] - 1)[:, None] * counts[0] + np.arange(counts[0] - 1)
    a = corner.ravel()
    b, c, d = a + 1, a + counts[0], a + counts[0] + 1
    return Mesh(
        vertices_world=np.column_stack([grid, np.zeros(len(grid))]),
        triangles=np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)]),
        colours=np.tile(_TABLE_RGB, (len(grid), 1)),
        kinds=np.full(len(grid), SurfaceKind.SUPPORT, dtype=np.uint8),
    )


class TablePainter:
    """Colours a table's mesh with what a view from above mostly shows there.

    The median over time leaves out hands; what stood there all the time is painted where it is
    seen.
    """

    def __init__(self, mesh: Mesh, view: PosedCamera) -> None:
        """Find out where the vertices are seen."""
        self._mesh = mesh
        uv_px = view.project(mesh.vertices_world)
        self._is_seen = view.camera.contains(uv_px)
        self._uv = np.round(uv_px[self._is_seen]).astype(np.int64)
        self._samples: list[ImageArray] = []
        self._last_ns: int | None = None

    def add(self, frame: Frame) -> None:
        """Take a frame now and then."""
        if self._last_ns is None or frame.t_ns - self._last_ns >= _PAINT_PERIOD_NS:
            self._last_ns = frame.t_ns
            self._samples.append(as_bgr(frame.image)[self._uv[:, 1], self._uv[:, 0]])

    def painted(self) -> Mesh:
        """Return the mesh with colours, grey where nothing was seen."""
        if not self._samples:
            return self._mesh
        colours = self._mesh.colours.copy()
        colours[self._is_seen] = np.median(self._samples, axis=0)[:, ::-1].astype(np.uint8)
        return replace(self._mesh, colours=colours)


def box_vertices(size_m: FloatArray) -> FloatArray:
    """Return the corners (8, 3) of a box in its own frame, as `BOX_TRIANGLES` counts them."""
    corners: FloatArray = _SIGNS * size_m
    return corners


def with_boxes(background: Mesh, objects: tuple[SceneObject, ...]) -> Mesh:
    """Return a mesh with the objects where they first stood."""
    return joined([background, *(_box_mesh(thing) for thing in objects)])


def _box_mesh(thing: SceneObject) -> Mesh:
    colour = np.clip(thing.mean_bgr[::-1], 0, 255).astype(np.uint8)
    return Mesh(
        vertices_world=thing.track[0].T_world_body.transform(box_vertices(thing.size_m)),
        triangles=BOX_TRIANGLES,
        colours=np.tile(colour, (8, 1)),
        kinds=np.full(8, SurfaceKind.BOX, dtype=np.uint8),
    )


def joined(meshes: list[Mesh]) -> Mesh:
    """Return several meshes (at least one) as one; kinds are kept where all have them."""
    starts = np.cumsum([0, *(len(mesh.vertices_world) for mesh in meshes)])
    kinds = [mesh.kinds for mesh in meshes if mesh.kinds is not None]
    return Mesh(
        vertices_world=np.concatenate([mesh.vertices_world for mesh in meshes]),
        triangles=np.concatenate(
            [mesh.triangles + start for mesh, start in zip(meshes, starts[:-1], strict=True)]
        ),
        colours=np.concatenate([mesh.colours for mesh in meshes]),
        kinds=np.concatenate(kinds) if len(kinds) == len(meshes) else None,
    )
