"""Pictures of the simulated world, exact at edges and quick between them.

One ray in each corner of a cell of a few pixels finds the faces; where the corners agree the
whole cell is that face, for faces are convex and bigger than a cell. Elsewhere, and where a face
has its corner in the cell, every pixel's ray is cast; pixels on an edge are the mean of four rays.
"""

from dataclasses import dataclass

import numpy as np

from gazemap.geometry.arrays import BoolArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.sim.casting import Caster
from gazemap.sim.model import Model, Moment
from gazemap.sim.shading import Float32Array, Int32Array, Samples, Shutter

CELL_PX = 4
_UNKNOWN = -2
_SUBPIXELS = ((-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25))


@dataclass(frozen=True, slots=True, kw_only=True)
class Window:
    """A part of the image: rows top to below bottom, columns left to below right."""

    top: int
    bottom: int
    left: int
    right: int

    @property
    def part(self) -> tuple[slice, slice]:
        """The window as an index of an image."""
        return slice(self.top, self.bottom), slice(self.left, self.right)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rendering:
    """A picture of a window.

    Attributes:
        bgr: (h, w, 3), 0..255, before lens blur and noise.
        far_m: distances along the rays at every `CELL_PX`-th pixel, and in the last ones.
    """

    bgr: Float32Array
    far_m: Float32Array


class Renderer:
    """One camera before the model."""

    def __init__(self, camera: Camera, model: Model) -> None:
        """Prepare the rays of all pixels: through the centre, and four around it for edges."""
        self.camera, self._model = camera, model
        height, width = camera.height_px, camera.width_px
        self.whole = Window(top=0, bottom=height, left=0, right=width)
        v, u = np.mgrid[0:height, 0:width]
        centre_px = np.column_stack([u.ravel(), v.ravel()]).astype(np.float64)
        self._row = v.astype(np.int32)
        rays = camera.unproject(centre_px).reshape(height, width, 3)
        down, across = (np.asarray(np.gradient(rays, axis=axis)) for axis in (0, 1))
        around = (rays + du * across + dv * down for du, dv in _SUBPIXELS)
        self._rays = [each.astype(np.float32) for each in (rays, *around)]

    def render(self, moment: Moment, shutter: Shutter, window: Window) -> Rendering:
        """Return the picture that the lens throws into a window."""
        caster = Caster(self._model, moment, shutter)
        part = window.part
        rays, row = self._rays[0][part].reshape(-1, 3), self._row[part].ravel()
        face, far_m = self._find_cells(caster, shutter, window)
        unknown = np.flatnonzero(face == _UNKNOWN)
        hits = caster.meet(rays[unknown], row[unknown])
        face.ravel()[unknown] = hits.face
        colours = caster.colour(Samples(ray_cam=rays, row=row, face=face.ravel()))
        seen = colours[unknown]
        caster.paint_hand(seen, hits)
        colours[unknown] = seen
        edge = np.flatnonzero(_edges(face))
        colours[edge] = self._supersample(caster, part, edge)
        return Rendering(bgr=colours.reshape(*face.shape, 3), far_m=far_m)

    def _find_cells(
        self, caster: Caster, shutter: Shutter, window: Window
    ) -> tuple[Int32Array, Float32Array]:
        """Return the faces of pixels (h, w), where cells tell, and the corners' distances."""
        rows = _corners(window.top, window.bottom)
        columns = _corners(window.left, window.right)
        at = np.ix_(rows, columns)
        hits = caster.meet(self._rays[0][at].reshape(-1, 3), self._row[at].ravel())
        corner = hits.face.reshape(len(rows), len(columns))
        same = (corner[1:, 1:] == corner[:-1, :-1]) & (corner[1:, :-1] == corner[:-1, :-1])
        same &= (corner[:-1, 1:] == corner[:-1, :-1]) & (corner[:-1, :-1] != caster.hand_face)
        same &= ~self._holding_vertices(caster, shutter, rows=rows, columns=columns)
        cells = np.where(same, corner[:-1, :-1], np.int32(_UNKNOWN))
        face = np.repeat(np.repeat(cells, _spans(rows), axis=0), _spans(columns), axis=1)
        return face, hits.far_m.reshape(corner.shape)

    def _holding_vertices(
        self, caster: Caster, shutter: Shutter, *, rows: IntArray, columns: IntArray
    ) -> BoolArray:
        """Return the cells (R - 1, C - 1) with, or next to, a corner of a face."""
        middle = self.camera.height_px // 2
        T_world_cam: Pose[World, Cam] = Pose(
            R=shutter.R_world_cam[middle], t=shutter.p_world_cam[middle]
        )
        vertices = caster.geometry.vertices[: 4 * caster.hand_face].astype(np.float64)
        uv_px = self.camera.project(T_world_cam.inverse().transform(vertices))
        uv_px = uv_px[self.camera.contains(uv_px)]
        holding = np.zeros((len(rows) - 1, len(columns) - 1), dtype=np.bool_)
        for du, dv in _SUBPIXELS:
            i = np.searchsorted(rows, uv_px[:, 1] + 8 * dv, side="right") - 1
            j = np.searchsorted(columns, uv_px[:, 0] + 8 * du, side="right") - 1
            inside = (i >= 0) & (i < holding.shape[0]) & (j >= 0) & (j < holding.shape[1])
            holding[i[inside], j[inside]] = True
        return holding

    def _supersample(
        self, caster: Caster, part: tuple[slice, slice], pixels: IntArray
    ) -> Float32Array:
        """Return the colours (N, 3) of pixels of a window, each the mean of its four rays."""
        rays = np.concatenate([each[part].reshape(-1, 3)[pixels] for each in self._rays[1:]])
        row = np.tile(self._row[part].ravel()[pixels], len(_SUBPIXELS))
        hits = caster.meet(rays, row)
        colours = caster.colour(Samples(ray_cam=rays, row=row, face=hits.face))
        caster.paint_hand(colours, hits)
        mean: Float32Array = colours.reshape(len(_SUBPIXELS), -1, 3).mean(axis=0)
        return mean


def _corners(first: int, end: int) -> IntArray:
    return np.append(np.arange(first, end - 1, CELL_PX), end - 1)


def _spans(corners: IntArray) -> IntArray:
    """Return how many pixels each cell has; the last corner belongs to the last cell."""
    spans = np.diff(corners)
    spans[-1] += 1
    return spans


def _edges(face: Int32Array) -> BoolArray:
    """Return which pixels (H, W) have a neighbour on another face."""
    edge = np.zeros(face.shape, dtype=np.bool_)
    across, down = face[:, 1:] != face[:, :-1], face[1:] != face[:-1]
    edge[:, 1:] |= across
    edge[:, :-1] |= across
    edge[1:] |= down
    edge[:-1] |= down
    return edge
