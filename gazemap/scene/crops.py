"""Cut-outs around a place: what a camera sees there, without its lens's distortion."""

from dataclasses import dataclass
from typing import TypeVar

import cv2
import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Pose, World
from gazemap.types.frame import Frame

_LENS_KNOTS = 9
F = TypeVar("F")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PosedCamera:
    """A camera and where it stands, whichever of the rig's cameras it is.

    Attributes:
        camera: the camera.
        R_world_cam: (3, 3).
        p_world_cam: (3,) its centre in world.
        is_overhead: whether it is the fixed camera over the table.
    """

    camera: Camera
    R_world_cam: FloatArray
    p_world_cam: FloatArray
    is_overhead: bool

    @staticmethod
    def of(camera: Camera, T_world_cam: Pose[World, F], *, is_overhead: bool) -> "PosedCamera":
        """Return a camera at a pose."""
        return PosedCamera(
            camera=camera,
            R_world_cam=T_world_cam.R,
            p_world_cam=T_world_cam.t,
            is_overhead=is_overhead,
        )

    def project(self, points_world: FloatArray) -> FloatArray:
        """Return pixels (N, 2) of points (N, 3) in world; NaN where not in front."""
        return self.camera.project((points_world - self.p_world_cam) @ self.R_world_cam)

    def sees(self, points_world: FloatArray) -> bool:
        """Whether all points (N, 3) lie in the image."""
        return bool(self.camera.contains(self.project(points_world)).all())

    def on_plane(self, uv_px: FloatArray, z_m: float = 0.0) -> FloatArray:
        """Return where the rays of pixels (N, 2) meet the level z_m (N, 2); NaN above horizon."""
        rays_world = self.camera.unproject(uv_px) @ self.R_world_cam.T
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = (z_m - self.p_world_cam[2]) / rays_world[:, 2]
        reach[~(reach > 0)] = np.nan
        xy: FloatArray = (self.p_world_cam + reach[:, None] * rays_world)[:, :2]
        return xy


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Crop:
    """A square pinhole image of a place.

    Attributes:
        t_ns: the frame's time.
        image: (n, n, 3) BGR.
        valid: (n, n) which pixels lie in the camera's image.
        projection: (3, 4) world to pixel of the cut-out.
        is_overhead: whether the overhead camera took it.
        distance_m: of the place from the camera.
        grain_m: how much of the place a pixel covers, of the cut-out or of the camera's image,
            whichever is the coarser.
    """

    t_ns: int
    image: ImageArray
    valid: BoolArray
    projection: FloatArray
    is_overhead: bool
    distance_m: float
    grain_m: float


def as_bgr(image: ImageArray) -> ImageArray:
    """Return a colour image (h, w, 3), whatever the recording has."""
    if image.ndim == 3:
        return image
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR), dtype=np.uint8)


def cut_out(
    frame: Frame, view: PosedCamera, *, centre_world: FloatArray, span_m: float, size_px: int
) -> Crop | None:
    """Return what a view sees around a point, or None where the point is out of the image.

    The cut-out is a pinhole camera that looks straight at the point, so that fitting needs no
    lens model; it spans span_m at the point's distance.
    """
    if not view.sees(centre_world[None]):
        return None
    toward = centre_world - view.p_world_cam
    distance = float(np.linalg.norm(toward))
    forward = toward / distance
    right = np.cross(view.R_world_cam[:, 1], forward)
    right /= np.linalg.norm(right)
    R_crop_world = np.stack([right, np.cross(forward, right), forward])
    focal_px = size_px * distance / span_m
    middle = (size_px - 1) / 2
    K_crop = np.array([[focal_px, 0, middle], [0, focal_px, middle], [0, 0, 1]])
    uv_px = _lens_map(view, R_crop_world, focal_px=focal_px, size_px=size_px)
    maps = np.ascontiguousarray(uv_px, dtype=np.float32)
    image = cv2.remap(as_bgr(frame.image), maps[..., 0], maps[..., 1], cv2.INTER_LINEAR)
    T_crop_world = np.column_stack([R_crop_world, -R_crop_world @ view.p_world_cam])
    return Crop(
        t_ns=frame.t_ns,
        image=np.asarray(image, dtype=np.uint8),
        valid=view.camera.contains(uv_px.reshape(-1, 2)).reshape(size_px, size_px),
        projection=K_crop @ T_crop_world,
        is_overhead=view.is_overhead,
        distance_m=distance,
        grain_m=span_m / size_px * max(1.0, 1.0 / _spacing_px(uv_px)),
    )


def _spacing_px(uv_px: FloatArray) -> float:
    """Return how far apart neighbouring pixels (n, n, 2) of a cut-out lie in the image."""
    middle = len(uv_px) // 2
    at = uv_px[middle, middle]
    beside, below = uv_px[middle, middle + 1] - at, uv_px[middle + 1, middle] - at
    return max(min(float(np.hypot(*beside)), float(np.hypot(*below))), 1e-3)


def _lens_map(
    view: PosedCamera, R_crop_world: FloatArray, *, focal_px: float, size_px: int
) -> FloatArray:
    """Return where the pixels of a cut-out lie in the image (n, n, 2).

    The lens is evaluated on a coarse grid and interpolated: it hardly bends over a cut-out.
    """
    middle = (size_px - 1) / 2
    knots = np.linspace(0, size_px - 1, _LENS_KNOTS)
    u, v = np.meshgrid((knots - middle) / focal_px, (knots - middle) / focal_px)
    rays_crop = np.stack([u, v, np.ones(u.shape)], axis=-1).reshape(-1, 3)
    uv_px = view.camera.project(rays_crop @ R_crop_world @ view.R_world_cam)
    grid = np.nan_to_num(uv_px, nan=-1e4).reshape(_LENS_KNOTS, _LENS_KNOTS, 2)
    at = np.linspace(0, _LENS_KNOTS - 1, size_px)
    low = np.minimum(at.astype(int), _LENS_KNOTS - 2)
    share = (at - low)[:, None]
    rows = grid[low] * (1 - share[:, None]) + grid[low + 1] * share[:, None]
    dense: FloatArray = rows[:, low] * (1 - share) + rows[:, low + 1] * share
    return dense
