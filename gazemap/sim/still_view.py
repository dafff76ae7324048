"""A camera that does not move draws only what changed since its last picture."""

import numpy as np

from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Overhead, Pose, World
from gazemap.sim.model import Model, Moment
from gazemap.sim.renderer import Renderer, Rendering, Window
from gazemap.sim.sensors import still_shutter
from gazemap.sim.shading import Float32Array
from gazemap.sim.shadows import on_table

_MARGIN_PX = 12  # the softness of shadows and of edges


class StillView:
    """One fixed camera; pictures are asked for in the order of time."""

    def __init__(self, camera: Camera, model: Model, T_world_cam: Pose[World, Overhead]) -> None:
        """Prepare the rays."""
        self._renderer, self._model = Renderer(camera, model), model
        self._camera, self._T_cam_world = camera, T_world_cam.inverse()
        self._shutter = still_shutter(camera, T_world_cam)
        self._bodies: list[FloatArray] = []
        self._bgr: Float32Array | None = None

    def render(self, moment: Moment) -> Rendering:
        """Return the whole picture at a moment; what it holds changes with the next call."""
        bodies = self._model.bodies(moment)
        if self._bgr is None:
            self._bgr = self._draw(moment, self._renderer.whole)
        elif window := self._changed(bodies):
            self._bgr[window.part] = self._draw(moment, window)
        self._bodies = bodies
        return Rendering(bgr=self._bgr, far_m=np.zeros((0, 0), np.float32))

    def _draw(self, moment: Moment, window: Window) -> Float32Array:
        return self._renderer.render(moment, self._shutter, window).bgr

    def _changed(self, bodies: list[FloatArray]) -> Window | None:
        """Return a window around all bodies that moved, and their shadows, before and after."""
        pairs = zip(self._bodies, bodies, strict=True)
        moved = [each for pair in pairs if not np.array_equal(*pair) for each in pair]
        if not moved:
            return None
        points = np.concatenate(moved)
        points = np.concatenate([points, on_table(points)])
        uv_px = self._camera.project(self._T_cam_world.transform(points))
        size = (self._camera.width_px, self._camera.height_px)
        low = np.clip(np.nanmin(uv_px, axis=0) - _MARGIN_PX, 0, size).astype(int)
        high = np.clip(np.nanmax(uv_px, axis=0) + _MARGIN_PX, 0, size).astype(int)
        if (high - low < 2).any():
            return None
        left, top, right, bottom = (int(x) for x in (*low, *high))
        return Window(top=top, bottom=bottom, left=left, right=right)
