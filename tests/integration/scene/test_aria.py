"""A recording of another rig: given poses, gaze and depth, the gaze must land on the fork."""

import json
from pathlib import Path

import numpy as np
import pytest

from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Pose
from gazemap.scene.cast import SceneCaster
from gazemap.scene.crops import PosedCamera
from gazemap.scene.fusion import DepthView, fuse_depth
from gazemap.types.scene import SceneModel, SurfaceHit, SurfaceKind

RECORDING = Path(__file__).parents[4] / "shared" / "data" / "recordings" / "aria_adt"
REDUCTION = 2

pytestmark = pytest.mark.skipif(
    not RECORDING.is_dir(), reason="shared/data/recordings/aria_adt is not there"
)


@pytest.fixture(scope="module")
def rig() -> dict:
    return json.loads((RECORDING / "rgb_export" / "frames.json").read_text())


@pytest.fixture(scope="module")
def camera(rig) -> Camera:
    f, (u, v) = rig["undistorted_pinhole_f"], rig["undistorted_pp"]
    K = np.array([[f, 0, u], [0, f, v], [0, 0, REDUCTION]]) / REDUCTION
    side = rig["image_size"][0] // REDUCTION
    return Camera(width_px=side, height_px=side, K=K, distortion=np.zeros(0))


def pose_of(rig: dict, k: int) -> Pose:
    given = rig["frames"][k]["T_world_device"]
    T_world_device = Pose.from_quat_xyzw(given["q_xyzw"], given["t"])
    R = np.array(rig["T_device_camera"])
    u, _, vt = np.linalg.svd(R[:3, :3])
    return T_world_device @ Pose(R=u @ vt, t=R[:3, 3])


def raw_px(rig: dict, flat: np.ndarray) -> np.ndarray:
    """Return pixels (N, 2) of x/z, y/z (N, 2) on the raw image: Aria's FISHEYE624."""
    f, cu, cv, *rest = rig["projection_params"]
    k, (p0, p1), (s0, s1, s2, s3) = rest[:6], rest[6:8], rest[8:]
    r = np.linalg.norm(flat, axis=1)
    theta = np.arctan(r)
    bent = theta * (1 + sum(c * theta ** (2 * i + 2) for i, c in enumerate(k)))
    x, y = (flat * (bent / np.maximum(r, 1e-9))[:, None]).T
    q, t = x * x + y * y, 2 * (x * p0 + y * p1)
    u = x + t * x + q * p0 + s0 * q + s1 * q * q
    v = y + t * y + q * p1 + s2 * q + s3 * q * q
    return f * np.column_stack([u, v]) + [cu, cv]


def straightened(rig: dict, camera: Camera, image: np.ndarray) -> np.ndarray:
    """Return a raw depth or instance image as the pinhole sees it, nearest neighbours."""
    v, u = np.mgrid[0 : camera.height_px, 0 : camera.width_px].reshape(2, -1).astype(float)
    at = np.round(raw_px(rig, camera.normalize(np.column_stack([u, v])))).astype(int)
    inside = ((at >= 0) & (at < image.shape[0])).all(axis=1)
    flat = np.zeros(len(at), dtype=image.dtype)
    flat[inside] = image[at[inside, 1], at[inside, 0]]
    return flat.reshape(camera.height_px, camera.width_px)


def fused(rig: dict, camera: Camera, k: int) -> SceneCaster:
    """Return one frame's depth as a surface: the fork is held, and moves between frames."""
    depth_mm = np.load(RECORDING / "rgb_export" / f"depth_{k:03}.npz")["a"]
    depth_m = (straightened(rig, camera, depth_mm) / 1000).astype(np.float32)
    posed = PosedCamera.of(camera, pose_of(rig, k), is_overhead=False)
    mesh = fuse_depth(
        [DepthView(depth_m=depth_m, view=posed)],
        voxel_m=0.003,
        far_m=4.0,
        kind=SurfaceKind.MEASURED,
    )
    assert mesh is not None
    return SceneCaster(
        SceneModel(
            mesh=mesh, background=mesh, objects=(), T_world_overhead=None, surface_sigma_m=0.002
        )
    )


@pytest.mark.parametrize("k", [0, 1])
def test_gaze_lands_on_the_wooden_fork(rig, camera, k):
    frame = rig["frames"][k]
    T_world_cam = pose_of(rig, k)
    ray_cam = camera.unproject(np.array([frame["gaze_px_undist"]]) / REDUCTION)
    hit = fused(rig, camera, k).cast(
        t_ns=0, origins_world=T_world_cam.t[None], directions_world=T_world_cam.rotate(ray_cam)
    )[0]
    assert isinstance(hit, SurfaceHit)
    seen = T_world_cam.inverse().transform(hit.point_world[None])
    assert 0.415 < seen[0, 2] < 0.445
    assert seen[0, 2] == pytest.approx(frame["depth_at_gaze"] / 1000, abs=0.006)
    instances = np.load(RECORDING / "rgb_export" / f"seg_{k:03}.npz")["a"]
    u, v = np.round(camera.project(seen)[0]).astype(int)
    known = json.loads((RECORDING / "instances.json").read_text())
    met = straightened(rig, camera, instances)[v, u]
    assert known[str(met)]["instance_name"] == "WoodenFork"
