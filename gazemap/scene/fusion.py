"""Depth images fused into one surface: a weighted truncated signed distance in Open3D."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from gazemap.geometry.arrays import FloatArray, ImageArray
from gazemap.scene.cast import open3d
from gazemap.scene.crops import PosedCamera
from gazemap.types.scene import Mesh, SurfaceKind

_OPEN3D_STRIDE = 4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DepthView:
    """One depth image of a posed camera.

    Attributes:
        depth_m: (h, w) along the optical axis, on the distorted image; NaN where unknown.
        view: the camera and where it stood.
        image: (h, w, 3) BGR for colours, or None.
    """

    depth_m: NDArray[np.float32]
    view: PosedCamera
    image: ImageArray | None = None


def fuse_depth(
    views: Iterable[DepthView], *, voxel_m: float, far_m: float, kind: SurfaceKind
) -> Mesh | None:
    """Return the fused surface in world, or None where the images show none.

    Each image is first drawn without its lens's distortion. What moved through the scene is
    averaged away by the images that saw through it.

    Args:
        views: what is fused; a voxel's weight is the number of images that saw it.
        voxel_m: how fine the surface is.
        far_m: depth beyond this is left out.
        kind: what the surface is marked as.

    Source:
        Curless and Levoy 1996, as in Open3D's voxel blocks.
    """
    o3d = open3d()
    core = o3d.core
    grid = o3d.t.geometry.VoxelBlockGrid(
        attr_names=("tsdf", "weight", "color"),
        attr_dtypes=(core.float32, core.float32, core.float32),
        attr_channels=((1), (1), (3)),
        voxel_size=voxel_m,
        block_resolution=8,
        block_count=10_000,
        device=core.Device("CPU:0"),
    )
    is_empty = True
    for view in views:
        straight = _without_lens(view)
        if not _is_seen_by_open3d(straight[0], far_m=far_m):
            continue
        images = [o3d.t.geometry.Image(core.Tensor.from_numpy(x)) for x in straight]
        lens = core.Tensor(np.array(view.view.camera.K))
        pose = core.Tensor(_cam_from_world(view.view))
        blocks = grid.compute_unique_block_coordinates(images[0], lens, pose, 1.0, far_m)
        if len(blocks) > 0:
            grid.integrate(blocks, *images, lens, pose, 1.0, far_m)
            is_empty = False
    return None if is_empty else _mesh_of(grid, kind)


def _is_seen_by_open3d(depth_m: NDArray[np.float32], *, far_m: float) -> bool:
    """Return whether Open3D, which looks at one pixel in four each way, meets any depth (h, w).

    It takes an image in which it meets none for an error.
    """
    rows, columns = (size // _OPEN3D_STRIDE * _OPEN3D_STRIDE for size in depth_m.shape)
    looked_at = depth_m[:rows:_OPEN3D_STRIDE, :columns:_OPEN3D_STRIDE]
    return bool(((looked_at > 0) & (looked_at < far_m)).any())


def _mesh_of(grid: Any, kind: SurfaceKind) -> Mesh | None:  # noqa: ANN401 - Open3D has no types
    """Return the surface of a volume as our record; what one image saw is enough."""
    mesh = grid.extract_triangle_mesh(0.5)
    if len(mesh.triangle.indices) == 0:
        return None
    colours = np.clip(mesh.vertex.colors.numpy(), 0, 1)
    count = len(colours)
    return Mesh(
        vertices_world=mesh.vertex.positions.numpy().astype(np.float64),
        triangles=mesh.triangle.indices.numpy().astype(np.int64),
        colours=np.round(colours * 255).astype(np.uint8),
        kinds=np.full(count, kind, dtype=np.uint8),
    )


def _cam_from_world(view: PosedCamera) -> FloatArray:
    """Return `T_cam_world` (4, 4), as Open3D wants it."""
    full = np.eye(4)
    full[:3, :3] = view.R_world_cam.T
    full[:3, 3] = -view.R_world_cam.T @ view.p_world_cam
    return full


def _without_lens(view: DepthView) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return depth (0 where unknown) and RGB (0 to 1) as a pinhole of that matrix sees them."""
    camera = view.view.camera
    v, u = np.mgrid[0 : camera.height_px, 0 : camera.width_px].reshape(2, -1).astype(np.float64)
    rays = np.column_stack([u, v, np.ones(len(u))]) @ np.linalg.inv(camera.K).T
    maps = camera.project(rays).astype(np.float32).reshape(camera.height_px, camera.width_px, 2)
    depth = np.nan_to_num(view.depth_m).astype(np.float32)
    straight = cv2.remap(depth, maps[..., 0], maps[..., 1], cv2.INTER_NEAREST)
    image = view.image
    if image is None:
        image = np.full((*depth.shape, 3), 150, dtype=np.uint8)
    colour = cv2.remap(image, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR)
    rgb = np.ascontiguousarray(colour[..., ::-1], dtype=np.float32) / np.float32(255)
    return np.ascontiguousarray(straight, dtype=np.float32), rgb
