"""The cameras: where they are, when their rows are exposed, and what they make of the light."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from gazemap.geometry.arrays import ImageArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Overhead, Pose, World
from gazemap.sim.config import ImagingConfig, LensConfig
from gazemap.sim.head import HeadPath
from gazemap.sim.renderer import CELL_PX, Rendering
from gazemap.sim.shading import Float32Array, Shutter

_LENS_BLUR_SIGMA_PX = 0.45
_NOISE_SIDE_PX = 1200
_BLUR_STEPS = 5
_FLOW_GRID_PX = 40
_OVERHEAD_AT_WORLD = np.array([0.06, -0.12, 1.25])
_OVERHEAD_TILT_RAD = 0.114
_OVERHEAD_YAW_RAD = 0.43


def build_camera(lens: LensConfig, *, readout_s: float = 0.0) -> Camera:
    """Return the camera of a lens, scaled to the width of its image."""
    scale = lens.width_px / lens.nominal_width_px
    K = np.diag([lens.focal_px[0] * scale, lens.focal_px[1] * scale, 1.0])
    K[0, 2] = (lens.width_px - 1) / 2 + lens.centre_offset_px[0] * scale
    K[1, 2] = (lens.height_px - 1) / 2 + lens.centre_offset_px[1] * scale
    return Camera(
        width_px=lens.width_px,
        height_px=lens.height_px,
        K=K,
        distortion=np.array(lens.distortion),
        lens=lens.model,
        serial=lens.serial,
        readout_s=readout_s or None,
    )


def hang_overhead(rng: np.random.Generator) -> Pose[World, Overhead]:
    """Draw where the overhead camera hangs: above the table, a little turned and tilted."""
    yaw = _OVERHEAD_YAW_RAD + rng.uniform(-0.12, 0.12)
    tilt = _OVERHEAD_TILT_RAD + rng.uniform(-0.04, 0.04)
    down = Rotation.from_euler("x", np.pi)  # looks down, image up is +y
    turn = Rotation.from_euler("z", yaw) * down * Rotation.from_euler("x", tilt)
    at = _OVERHEAD_AT_WORLD + rng.uniform(-0.04, 0.04, 3)
    return Pose(R=turn.as_matrix(), t=at)


def still_shutter(camera: Camera, T_world_cam: Pose[World, Overhead]) -> Shutter:
    """Return the shutter of a camera that does not move."""
    rows = camera.height_px
    return Shutter(
        R_world_cam=np.repeat(T_world_cam.R[None], rows, axis=0),
        p_world_cam=np.repeat(T_world_cam.t[None], rows, axis=0),
        focal_px=float(camera.K[0, 0]),
    )


def head_shutter(camera: Camera, head: HeadPath, t_s: float) -> Shutter:
    """Return the shutter of the head camera for the frame whose middle row is exposed at t_s."""
    delays_s = camera.row_delay_ns(np.arange(camera.height_px, dtype=np.float64)) / 1e9
    R, p = head.poses(t_s + delays_s)
    return Shutter(
        R_world_cam=np.ascontiguousarray(R), p_world_cam=p, focal_px=float(camera.K[0, 0])
    )


class Sensor:
    """Turns the light of one camera into its images; the noise follows from the generator."""

    def __init__(self, config: ImagingConfig, camera: Camera, rng: np.random.Generator) -> None:
        """Draw a sheet of noise, of which each frame takes another part, and the light's waves."""
        self._config, self._camera, self._rng = config, camera, rng
        side = _NOISE_SIDE_PX
        noise = rng.normal(0.0, config.noise_levels, (side, side, 3))
        self._noise = np.asarray(noise, dtype=np.float32)

    def expose(
        self, rendering: Rendering, *, gain: float, blur_map: "BlurMap | None"
    ) -> ImageArray:
        """Return the image (H, W, 3), BGR, of a rendering."""
        light = rendering.bgr if blur_map is None else blur_map.smear(rendering.bgr)
        light = np.asarray(cv2.GaussianBlur(light, (3, 3), _LENS_BLUR_SIGMA_PX), np.float32)
        noisy = light * np.float32(gain) + self._next_noise(light.shape)
        return np.asarray(np.clip(noisy + 0.5, 0, 255), dtype=np.uint8)

    def _next_noise(self, shape: tuple[int, ...]) -> Float32Array:
        room = np.array(self._noise.shape[:2]) - shape[:2]
        if (room <= 0).any():
            tiles = np.ceil(np.array(shape[:2]) / self._noise.shape[:2] + 0.1).astype(int)
            self._noise = np.tile(self._noise, (*tiles, 1))
            room = np.array(self._noise.shape[:2]) - shape[:2]
        y, x = (int(self._rng.integers(0, r + 1)) for r in room)
        return self._noise[y : y + shape[0], x : x + shape[1]]


def brightness(t_s: float, config: ImagingConfig) -> float:
    """Return how bright the room is at a time: 1 where the light does not change."""
    slow, quick = np.sin(2 * np.pi * t_s / 7.3), np.sin(2 * np.pi * t_s / 2.9 + 1.0)
    return float(1.0 + config.light_change * (0.65 * slow + 0.35 * quick))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BlurMap:
    """How far pixels move (H, W, 2) while a row is exposed."""

    flow_px: Float32Array

    def smear(self, bgr: Float32Array) -> Float32Array:
        """Return the mean of the picture along the flow."""
        height, width = bgr.shape[:2]
        v, u = np.mgrid[0:height, 0:width].astype(np.float32)
        total = np.zeros_like(bgr)
        for part in np.linspace(-0.5, 0.5, _BLUR_STEPS, dtype=np.float32):
            du, dv = part * self.flow_px[..., 0], part * self.flow_px[..., 1]
            total += cv2.remap(
                bgr, u + du, v + dv, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
            )
        return total / np.float32(_BLUR_STEPS)


def motion_blur(
    rendering: Rendering, camera: Camera, head: HeadPath, *, t_s: float, exposure_s: float
) -> BlurMap:
    """Return the flow of the still scene while the shutter is open, from a coarse grid."""
    height, width = rendering.bgr.shape[:2]
    v, u = (np.linspace(0, side - 1, max(3, side // _FLOW_GRID_PX)) for side in (height, width))
    grid_px = np.stack(np.meshgrid(u, v), axis=2).reshape(-1, 2)
    column, row = np.round(grid_px / CELL_PX).astype(int).T
    column, row = (
        np.minimum(column, rendering.far_m.shape[1] - 1),
        np.minimum(row, len(rendering.far_m) - 1),
    )
    far_m = np.clip(rendering.far_m[row, column], 0.1, 5.0)[:, None]
    now = head.T_world_cam(t_s)
    points = now.transform(camera.unproject(grid_px) * far_m)
    ends = [
        camera.project(head.T_world_cam(t_s + side * exposure_s).inverse().transform(points))
        for side in (-0.5, 0.5)
    ]
    flow = np.nan_to_num(ends[1] - ends[0]).reshape(len(v), len(u), 2)
    return BlurMap(
        flow_px=np.asarray(cv2.resize(flow.astype(np.float32), (width, height)), np.float32)
    )
