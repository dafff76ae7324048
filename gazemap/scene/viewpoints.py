"""Which frames of a path show the surroundings best, and which of them see depth together."""

import cv2
import numpy as np

from gazemap.geometry.arrays import FloatArray
from gazemap.ports import Session
from gazemap.scene.config import SweepConfig
from gazemap.scene.crops import PosedCamera, as_bgr
from gazemap.scene.sweep import StillView
from gazemap.types.frame import Frame
from gazemap.types.tracking import Trajectory

_TURN_WEIGHT = 0.7  # a turn of one radian counts as a move by so much of the usual distance
_STRIDE = 3  # candidates: every third pose


def choose_times(trajectory: Trajectory, *, reach: float, count: int) -> list[int]:
    """Return the times (ns) of poses as different from one another as can be, in that order.

    Each next one is the pose that is farthest from all that were chosen (farthest-point
    sampling), so that standing still yields no more views than a glance does.
    """
    index = np.arange(0, len(trajectory), _STRIDE)
    if len(index) == 0:
        return []
    R = np.array([trajectory.pose(int(i)).R for i in index])
    signature = np.column_stack(
        [trajectory.p_world_cam[index] / reach, _TURN_WEIGHT * R[:, :, 2], 0.3 * R[:, :, 0]]
    )
    away = np.full(len(index), np.inf)
    chosen = [0]
    while len(chosen) < min(count, len(index)):
        away = np.minimum(away, np.linalg.norm(signature - signature[chosen[-1]], axis=1))
        chosen.append(int(away.argmax()))
    return [int(trajectory.t_ns[index[k]]) for k in chosen]


def take_views(
    session: Session, trajectory: Trajectory, times_ns: list[int], config: SweepConfig
) -> list[StillView]:
    """Return the frames of a path at those times, in their order, small and undistorted."""
    wanted, views = set(times_ns), {}
    for frame in session.scene_frames():
        if frame.t_ns in wanted:
            T_world_cam = trajectory.at(frame.t_ns)
            if T_world_cam is not None:
                posed = PosedCamera.of(session.scene_camera, T_world_cam, is_overhead=False)
                views[frame.t_ns] = still_view(frame, posed, config)
    return [views[t_ns] for t_ns in dict.fromkeys(times_ns) if t_ns in views]


def still_view(frame: Frame, posed: PosedCamera, config: SweepConfig) -> StillView:
    """Return a frame as a pinhole camera of the same focal length would have seen it, small."""
    camera = posed.camera
    scale = min(1.0, config.width_px / camera.width_px)
    width, height = round(camera.width_px * scale), round(camera.height_px * scale)
    K = np.diag([scale, scale, 1.0]) @ camera.K
    K[:2, 2] += 0.5 * scale - 0.5  # pixel 0 is a pixel's centre at either size
    v, u = np.mgrid[0:height, 0:width].reshape(2, -1)
    rays = np.column_stack([u, v, np.ones(len(u))]) @ np.linalg.inv(K).T
    maps = camera.project(rays).astype(np.float32).reshape(height, width, 2)
    side = max(1, round(1 / scale))
    image = cv2.blur(as_bgr(frame.image), (side, side)) if side > 1 else as_bgr(frame.image)
    small = cv2.remap(image, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR)
    bgr = np.asarray(small, dtype=np.uint8)
    return StillView(
        grey=np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2GRAY), dtype=np.float32),
        bgr=bgr,
        K=K,
        R_world_cam=posed.R_world_cam,
        p_world_cam=posed.p_world_cam,
    )


def partners(k: int, views: tuple[StillView, ...], *, reach: float, count: int) -> list[int]:
    """Return the views (indices) that see what view k sees from well chosen other places.

    A pair is good where the rays to the middle of what both see meet at about 0.15 rad: closer
    gives no depth, wider no likeness.
    """
    view = views[k]
    middle = view.p_world_cam + reach * view.R_world_cam[:, 2]
    goodness = [
        (0.0 if j == k else _goodness(view, other, middle), j) for j, other in enumerate(views)
    ]
    best = sorted(goodness, reverse=True)[:count]
    return [j for good, j in best if good > 0.05]


def _goodness(view: StillView, other: StillView, middle_world: FloatArray) -> float:
    a, b = view.p_world_cam - middle_world, other.p_world_cam - middle_world
    cosine = a @ b / np.linalg.norm(a) / np.linalg.norm(b)
    angle = float(np.arccos(np.clip(cosine, -1, 1)))
    turned = float(np.arccos(np.clip(view.R_world_cam[:, 2] @ other.R_world_cam[:, 2], -1, 1)))
    wide = 0.15
    fits = (angle / wide) * np.exp(1 - angle / wide)
    return float(fits * np.exp(-0.5 * (turned / 0.35) ** 2))


def depth_range(view: StillView, points_world: FloatArray) -> tuple[float, float] | None:
    """Return between which depths a view's surroundings lie, by the map's points (M, 3)."""
    cam = (points_world - view.p_world_cam) @ view.R_world_cam
    front = cam[cam[:, 2] > 1e-6]
    uv_px = (front @ view.K.T)[:, :2] / front[:, 2:]
    height, width = view.shape
    inside = np.asarray(((uv_px > 0) & (uv_px < [width, height])).all(axis=1))
    if inside.sum() < 20:
        return None
    near, far = np.percentile(front[inside, 2], [2, 98])
    return 0.6 * float(near), 2.5 * float(far)
