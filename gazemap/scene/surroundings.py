"""What lies beside the table: walls, shelves, the floor, from depth images or from motion."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gazemap.geometry.arrays import BoolArray, FloatArray
from gazemap.geometry.camera import Camera
from gazemap.ports import Session
from gazemap.scene.config import SceneConfig
from gazemap.scene.crops import PosedCamera
from gazemap.scene.dense import DenseView, dense_views
from gazemap.scene.fusion import DepthView, fuse_depth
from gazemap.scene.sweep import Float32Array, StillView
from gazemap.scene.viewpoints import choose_times, take_views
from gazemap.types.frame import DepthFrame
from gazemap.types.scene import Mesh, SurfaceKind
from gazemap.types.tracking import Trajectory

_NEAR_TABLE_M = 0.45  # above it are the things, which have boxes, and hands, which are no surface
_BELOW_TABLE_M = 0.01
_FAR_M = 4.0
_FAR_SHARE = 5.0  # of the usual distance: what is farther is too uncertain to draw


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Surroundings:
    """What was measured beside the table.

    Attributes:
        meshes: surfaces, by how they are known.
        sigma_m: standard deviation along their normals.
    """

    meshes: tuple[Mesh, ...]
    sigma_m: float


def find_surroundings(
    session: Session,
    trajectory: Trajectory,
    *,
    table: Mesh | None,
    points_world: FloatArray,
    overhead: tuple[StillView, ...],
    config: SceneConfig,
) -> Surroundings:
    """Return what is seen around the table, from depth images where there are any.

    Args:
        session: the recording.
        trajectory: the head camera's path.
        table: the support; what lies on it or hovers over it is left out. None keeps all.
        points_world: (M, 3) the sparse map.
        overhead: views of a fixed camera, which count among the moving one's.
        config: settings.
    """
    reach = usual_distance(trajectory, points_world)
    own = _from_depth_images(session, trajectory, table, config)
    if own is not None:
        return Surroundings(meshes=(own,), sigma_m=config.voxel_m)
    sigma_m = config.measured_sigma_share * (reach or 1.0)
    if reach is None:
        return Surroundings(meshes=(), sigma_m=sigma_m)
    times_ns = choose_times(trajectory, reach=reach, count=config.sweep.pool)
    views = take_views(session, trajectory, times_ns, config.sweep)
    dense = dense_views((*overhead, *views), points_world, reach=reach, config=config.sweep)
    parts = [
        fuse_depth(
            (_as_depth_view(each, kind, table) for each in dense),
            voxel_m=config.sweep.voxel_share * reach,
            far_m=_FAR_SHARE * reach,
            kind=kind,
        )
        for kind in (SurfaceKind.MEASURED, SurfaceKind.FITTED)
    ]
    return Surroundings(meshes=tuple(p for p in parts if p is not None), sigma_m=sigma_m)


def usual_distance(trajectory: Trajectory, points_world: FloatArray) -> float | None:
    """Return how far the map's points (M, 3) in front of the camera mostly are, if there are any.

    Points far beyond the middle one's distance do not move a median.
    """
    if len(trajectory) == 0 or len(points_world) == 0:
        return None
    depths = []
    for i in np.linspace(0, len(trajectory) - 1, min(len(trajectory), 20)).astype(int):
        T_world_cam = trajectory.pose(int(i))
        cam = (points_world - T_world_cam.t) @ T_world_cam.R
        ahead = (cam[:, 2] > 0) & (np.abs(cam[:, :2]).max(axis=1) < 0.6 * cam[:, 2])
        depths.append(cam[ahead, 2])
    ahead_of_all = np.concatenate(depths)
    return float(np.median(ahead_of_all)) if len(ahead_of_all) else None


def _as_depth_view(each: DenseView, kind: SurfaceKind, table: Mesh | None) -> DepthView:
    view = each.view
    height, width = view.shape
    camera = Camera(width_px=width, height_px=height, K=view.K, distortion=np.zeros(0))
    depth = each.measured if kind is SurfaceKind.MEASURED else each.fitted
    posed = PosedCamera(
        camera=camera,
        R_world_cam=view.R_world_cam,
        p_world_cam=view.p_world_cam,
        is_overhead=False,
    )
    return DepthView(depth_m=_beside_table(depth, posed, table), view=posed, image=view.bgr)


def _from_depth_images(
    session: Session, trajectory: Trajectory, table: Mesh | None, config: SceneConfig
) -> Mesh | None:
    frames = session.scene_depth_frames()
    views = _depth_image_views(frames, session.scene_camera, trajectory, table, config)
    return fuse_depth(views, voxel_m=config.voxel_m, far_m=_FAR_M, kind=SurfaceKind.MEASURED)


def _depth_image_views(
    frames: Iterator[DepthFrame],
    camera: Camera,
    trajectory: Trajectory,
    table: Mesh | None,
    config: SceneConfig,
) -> Iterator[DepthView]:
    last_ns: int | None = None
    for frame in frames:
        if last_ns is not None and frame.t_ns - last_ns < config.depth_period_s * 1e9:
            continue
        T_world_cam = trajectory.at(frame.t_ns)
        if T_world_cam is None:
            continue
        last_ns = frame.t_ns
        posed = PosedCamera.of(camera, T_world_cam, is_overhead=False)
        yield DepthView(depth_m=_beside_table(frame.depth_m, posed, table), view=posed)


def _beside_table(
    depth_m: Float32Array, view: PosedCamera, table: Mesh | None
) -> NDArray[np.float32]:
    """Return the depth image (h, w) without what lies on the table or hovers over it."""
    if table is None:
        return depth_m
    v, u = np.mgrid[0 : depth_m.shape[0], 0 : depth_m.shape[1]]
    flat = view.camera.normalize(np.stack([u, v], -1).reshape(-1, 2).astype(np.float64))
    rays = np.column_stack([flat, np.ones(len(flat))]) * depth_m.reshape(-1, 1)
    points = rays @ view.R_world_cam.T + view.p_world_cam
    low = table.vertices_world.min(axis=0) - np.array([0, 0, _BELOW_TABLE_M])
    high = table.vertices_world.max(axis=0) + np.array([0, 0, _NEAR_TABLE_M])
    over: BoolArray = ((points > low) & (points < high)).all(axis=1).reshape(depth_m.shape)
    return np.where(over, np.nan, depth_m).astype(np.float32)
