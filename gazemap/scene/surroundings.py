"""What a rig with depth sees beside the table: walls, shelves, the floor."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gazemap.geometry.arrays import FloatArray
from gazemap.ports import Session
from gazemap.scene.config import SceneConfig
from gazemap.scene.crops import PosedCamera
from gazemap.scene.fusion import DepthView, fuse_depth
from gazemap.types.scene import Mesh
from gazemap.types.tracking import Trajectory

_NEAR_TABLE_M = 0.45  # above it are the things, which have boxes, and hands, which are no surface
_BELOW_TABLE_M = 0.01


def add_surroundings(
    table: Mesh, session: Session, trajectory: Trajectory, config: SceneConfig
) -> Mesh:
    """Return the table's mesh with what depth images show around it; as it is without depth."""
    around = fuse_depth(_views(session, trajectory, table, config), voxel_m=config.voxel_m)
    if around is None:
        return table
    return Mesh(
        vertices_world=np.concatenate([table.vertices_world, around.vertices_world]),
        triangles=np.concatenate([table.triangles, around.triangles + len(table.vertices_world)]),
        colours=np.concatenate([table.colours, around.colours]),
    )


def _views(
    session: Session, trajectory: Trajectory, table: Mesh, config: SceneConfig
) -> Iterator[DepthView]:
    last_ns: int | None = None
    for frame in session.scene_depth_frames():
        if last_ns is not None and frame.t_ns - last_ns < config.depth_period_s * 1e9:
            continue
        T_world_cam = trajectory.at(frame.t_ns)
        if T_world_cam is None:
            continue
        last_ns = frame.t_ns
        posed = PosedCamera.of(session.scene_camera, T_world_cam, is_overhead=False)
        view = DepthView(depth_m=frame.depth_m, view=posed)
        yield replace(view, depth_m=_beside_table(view, table.vertices_world))


def _beside_table(view: DepthView, table_world: FloatArray) -> NDArray[np.float32]:
    """Return the depth image (h, w) without what lies on the table or hovers over it."""
    v, u = np.mgrid[0 : view.depth_m.shape[0], 0 : view.depth_m.shape[1]]
    flat = view.view.camera.normalize(np.stack([u, v], -1).reshape(-1, 2).astype(np.float64))
    rays = np.column_stack([flat, np.ones(len(flat))]) * view.depth_m.reshape(-1, 1)
    points = rays @ view.view.R_world_cam.T + view.view.p_world_cam
    low = table_world.min(axis=0) - np.array([0, 0, _BELOW_TABLE_M])
    high = table_world.max(axis=0) + np.array([0, 0, _NEAR_TABLE_M])
    over = ((points > low) & (points < high)).all(axis=1).reshape(view.depth_m.shape)
    return np.where(over, np.nan, view.depth_m).astype(np.float32)
