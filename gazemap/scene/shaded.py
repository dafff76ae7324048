"""Pictures of a mesh from any side, by ray casting."""

import numpy as np

from gazemap.geometry.arrays import FloatArray, ImageArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.scene.cast import open3d
from gazemap.types.scene import Mesh

_SKY_BGR = np.array([250, 248, 246], dtype=np.uint8)
_AMBIENT = 0.55


def look_at(eye_world: FloatArray, target_world: FloatArray) -> Pose[World, Cam]:
    """Return the pose of an upright camera at one point (3,) that looks at another (3,)."""
    ahead = target_world - eye_world
    ahead = ahead / np.linalg.norm(ahead)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return Pose(R=np.column_stack([right, np.cross(ahead, right), ahead]), t=eye_world)


def shaded_view(mesh: Mesh, camera: Camera, T_world_cam: Pose[World, Cam]) -> ImageArray:
    """Return what a camera without distortion sees of a mesh (h, w, 3) BGR, lit from itself."""
    o3d = open3d()
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        o3d.core.Tensor.from_numpy(mesh.vertices_world.astype(np.float32)),
        o3d.core.Tensor.from_numpy(np.ascontiguousarray(mesh.triangles, dtype=np.uint32)),
    )
    v, u = np.mgrid[0 : camera.height_px, 0 : camera.width_px].reshape(2, -1)
    directions = camera.unproject(np.column_stack([u, v]).astype(np.float64)) @ T_world_cam.R.T
    origins = np.broadcast_to(T_world_cam.t, directions.shape)
    rays = np.hstack([origins, directions]).astype(np.float32)
    hits = scene.cast_rays(o3d.core.Tensor.from_numpy(rays))
    met = np.isfinite(hits["t_hit"].numpy())
    corners = mesh.triangles[hits["primitive_ids"].numpy()[met].astype(np.int64)]
    place = hits["primitive_uvs"].numpy()[met]
    weights = np.column_stack([1 - place.sum(axis=1), place])
    rgb = np.einsum("nk,nkc->nc", weights, mesh.colours[corners].astype(np.float64))
    facing = np.abs((hits["primitive_normals"].numpy()[met] * directions[met]).sum(axis=1))
    image = np.tile(_SKY_BGR, (len(rays), 1))
    image[met] = np.clip(rgb * (_AMBIENT + (1 - _AMBIENT) * facing[:, None]), 0, 255)[:, ::-1]
    return image.reshape(camera.height_px, camera.width_px, 3)
