"""Points with their reference patches, and how a camera sees them."""

from dataclasses import dataclass

import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.live.patches import LEVELS, STORED_SIDE

# Beyond these the reference no longer looks like the point.
_LARGEST_STRETCH = 2.2
_LEAST_VIEW_COSINE = 0.5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Landmarks:
    """Points of the map as the tracker uses them, sorted by id.

    Attributes:
        ids: (N,) strictly increasing.
        points_world: (N, 3).
        step_world: (N, 2, 3) by how much the point moves on its surface, taken to face the camera
            that saw it first, when its pixel there moves by one in x and in y.
        facing_world: (N, 3) unit direction from the point to that camera.
        view_count: (N,) keyframes that measured it.
        references: (N, 2, S, S) its patch.
    """

    ids: IntArray
    points_world: FloatArray
    step_world: FloatArray
    facing_world: FloatArray
    view_count: IntArray
    references: ImageArray

    @staticmethod
    def none() -> "Landmarks":
        """Return no landmarks."""
        return Landmarks(
            ids=np.empty(0, np.int64),
            points_world=np.empty((0, 3)),
            step_world=np.empty((0, 2, 3)),
            facing_world=np.empty((0, 3)),
            view_count=np.empty(0, np.int64),
            references=np.empty((0, LEVELS, STORED_SIDE, STORED_SIDE), np.uint8),
        )

    def __len__(self) -> int:
        return len(self.ids)

    def chosen(self, which: BoolArray) -> "Landmarks":
        """Return some of the landmarks."""
        return Landmarks(
            ids=self.ids[which],
            points_world=self.points_world[which],
            step_world=self.step_world[which],
            facing_world=self.facing_world[which],
            view_count=self.view_count[which],
            references=self.references[which],
        )

    def rows_of(self, ids: IntArray) -> tuple[IntArray, BoolArray]:
        """Return rows (N,) of ids, and which of them are there; the row of an absent one is 0."""
        if len(self.ids) == 0:
            return np.zeros(len(ids), np.int64), np.zeros(len(ids), bool)
        rows = np.minimum(np.searchsorted(self.ids, ids), len(self.ids) - 1)
        there = self.ids[rows] == ids
        return np.where(there, rows, 0), there


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class View:
    """Landmarks as a camera is predicted to see them.

    Attributes:
        rows: (V,) of the landmarks that are in the image.
        uv_px: (V, 2) where.
        from_image: (V, 2, 2) maps pixel offsets there to pixel offsets in the reference.
    """

    rows: IntArray
    uv_px: FloatArray
    from_image: FloatArray


def host_steps(camera: Camera, uv_px: FloatArray) -> FloatArray:
    """Return (N, 3, 3): the unit ray of each pixel, then its step in x and in y at unit range.

    The steps lie in the plane that faces the ray.
    """
    ray = camera.unproject(uv_px)
    out = np.empty((len(uv_px), 3, 3))
    out[:, 0] = ray
    for axis in range(2):
        moved = camera.unproject(uv_px + np.eye(2)[axis])
        out[:, 1 + axis] = moved / (moved * ray).sum(axis=1, keepdims=True) - ray
    return out


def see(
    camera: Camera,
    T_cam_world: Pose[Cam, World],
    points_world: FloatArray,
    step_world: FloatArray,
    facing_world: FloatArray,
    *,
    margin_px: float = 10.0,
) -> View:
    """Predict which points (N, 3) a camera sees, where, and how their patches look there."""
    points_cam = T_cam_world.transform(points_world)
    limit_x, limit_y = field_limits(camera)
    z = points_cam[:, 2]
    inside = (z > 1e-6) & (np.abs(points_cam[:, 0]) < limit_x * z)
    inside &= np.abs(points_cam[:, 1]) < limit_y * z
    to_camera = T_cam_world.inverse().t - points_world
    to_camera /= np.linalg.norm(to_camera, axis=1, keepdims=True) + 1e-12
    inside &= (to_camera * facing_world).sum(axis=1) > _LEAST_VIEW_COSINE
    rows = np.flatnonzero(inside)
    centre = points_cam[rows]
    step_cam = T_cam_world.rotate(step_world[rows])  # (V, 2, 3)
    stacked = np.concatenate([centre, centre + step_cam[:, 0], centre + step_cam[:, 1]])
    uv_px, uv_x, uv_y = np.split(camera.project(stacked), 3)
    to_image = np.stack([uv_x - uv_px, uv_y - uv_px], axis=2)
    determinant = to_image[:, 0, 0] * to_image[:, 1, 1] - to_image[:, 0, 1] * to_image[:, 1, 0]
    size = camera.width_px - 1 - margin_px, camera.height_px - 1 - margin_px
    with np.errstate(invalid="ignore"):
        good = (uv_px > margin_px).all(axis=1) & (uv_px < size).all(axis=1)
        good &= (determinant > _LARGEST_STRETCH**-2) & (determinant < _LARGEST_STRETCH**2)
    from_image = np.asarray(np.linalg.inv(to_image[good]), dtype=np.float64)
    return View(rows=rows[good], uv_px=uv_px[good], from_image=from_image)


def field_limits(camera: Camera) -> tuple[float, float]:
    """Return the largest |x/z| and |y/z| in the image, with a small margin."""
    w, h = camera.width_px - 1.0, camera.height_px - 1.0
    border = np.array(
        [[0, 0], [w, 0], [0, h], [w, h], [w / 2, 0], [w / 2, h], [0, h / 2], [w, h / 2]]
    )
    x, y = np.abs(camera.normalize(border)).max(axis=0)
    return float(x) * 1.02, float(y) * 1.02


def spread(uv_px: FloatArray, rank: FloatArray, *, count: int, camera: Camera) -> IntArray:
    """Return the indices of about `count` pixels (N, 2), the best ranked of each grid cell."""
    if len(uv_px) <= count:
        return np.arange(len(uv_px))
    cell_px = np.sqrt(camera.width_px * camera.height_px / count)
    column = (uv_px[:, 0] / cell_px).astype(np.int64)
    cell = (uv_px[:, 1] / cell_px).astype(np.int64) * 4096 + column
    order = np.lexsort((-rank, cell))
    first = np.ones(len(order), bool)
    first[1:] = cell[order][1:] != cell[order][:-1]
    chosen, rest = order[first], order[~first]
    best_rest = rest[np.argsort(-rank[rest], kind="stable")[: max(count - len(chosen), 0)]]
    return np.sort(np.concatenate([chosen, best_rest]))
