"""A view from above for a rig without an overhead camera: head frames drawn on the table.

What lies on the table is drawn where it is. What stands on it is smeared away from the head, and
creeps as the head moves: good enough to find things and to see them come and go, of no use for
measuring them.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from gazemap.geometry.arrays import FloatArray, ImageArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Overhead, Pose, World
from gazemap.scene.crops import PosedCamera, as_bgr
from gazemap.types.frame import Frame

_PIXEL_M = 0.0016
_HEIGHT_M = 1.2
_KNOT_PX = 20


class RectifiedTable:
    """Draws head frames as a camera straight above the table would see a flat table."""

    def __init__(self, outline_xy: FloatArray) -> None:
        """Look down on a table between opposite corners (2, 2)."""
        low, high = outline_xy
        width, height = np.ceil((high - low) / _PIXEL_M).astype(int)
        focal_px = _HEIGHT_M / _PIXEL_M
        K = np.array([[focal_px, 0, (width - 1) / 2], [0, focal_px, (height - 1) / 2], [0, 0, 1]])
        self.camera = Camera(
            width_px=int(width), height_px=int(height), K=K, distortion=np.zeros(0)
        )
        centre = (low + high) / 2
        self.T_world_overhead: Pose[World, Overhead] = Pose(
            R=np.diag([1.0, -1.0, -1.0]), t=np.array([*centre, _HEIGHT_M])
        )
        self._shown: ImageArray | None = None
        self._knots_world = self._knots(int(width), int(height))

    def _knots(self, width: int, height: int) -> FloatArray:
        u = np.linspace(0, width - 1, width // _KNOT_PX + 2)
        v = np.linspace(0, height - 1, height // _KNOT_PX + 2)
        view = PosedCamera.of(self.camera, self.T_world_overhead, is_overhead=True)
        grid = np.stack(np.meshgrid(u, v), axis=-1)
        xy = view.on_plane(grid.reshape(-1, 2))
        return np.column_stack([xy, np.zeros(len(xy))]).reshape(*grid.shape[:2], 3)

    def draw(self, frame: Frame, camera: Camera, T_world_cam: Pose[World, Cam]) -> Frame:
        """Return the table as this and earlier frames show it."""
        view = PosedCamera.of(camera, T_world_cam, is_overhead=False)
        rows, columns = self._knots_world.shape[:2]
        uv_px = view.project(self._knots_world.reshape(-1, 3)).reshape(rows, columns, 2)
        coarse = np.nan_to_num(uv_px, nan=-1e4).astype(np.float32)
        maps = _stretched(coarse, self.camera.width_px, self.camera.height_px)
        image = as_bgr(frame.image)
        drawn = np.asarray(cv2.remap(image, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR))
        seen = camera.contains(maps.reshape(-1, 2).astype(np.float64)).reshape(maps.shape[:2])
        if self._shown is None:
            usual = np.median(drawn[seen], axis=0) if seen.any() else np.zeros(3)
            self._shown = np.broadcast_to(usual, drawn.shape).astype(np.uint8)
        shown = np.where(seen[..., None], drawn, self._shown).astype(np.uint8)
        self._shown = shown
        return Frame(index=frame.index, t_ns=frame.t_ns, image=shown)


def _stretched(coarse: NDArray[np.float32], width: int, height: int) -> NDArray[np.float32]:
    """Return a coarse map interpolated to all pixels, its corners kept at the corners."""
    rows, columns = coarse.shape[:2]
    u = np.linspace(0, columns - 1, width, dtype=np.float32)
    v = np.linspace(0, rows - 1, height, dtype=np.float32)
    at_u, at_v = np.meshgrid(u, v)
    return np.asarray(cv2.remap(coarse, at_u, at_v, cv2.INTER_LINEAR), dtype=np.float32)
