"""Depth images fused into a surface."""

import numpy as np
import pytest

from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Pose
from gazemap.scene.crops import PosedCamera
from gazemap.scene.fusion import DepthView, fuse_depth
from gazemap.types.scene import SurfaceKind

WIDTH, HEIGHT = 82, 63
CAMERA = Camera(
    width_px=WIDTH,
    height_px=HEIGHT,
    K=np.array([[80.0, 0, 40.5], [0, 80, 31], [0, 0, 1]]),
    distortion=np.zeros(0),
)


def view_of(depth_m):
    posed = PosedCamera.of(CAMERA, Pose(R=np.eye(3), t=np.zeros(3)), is_overhead=False)
    return DepthView(depth_m=depth_m.astype(np.float32), view=posed)


def fused(depth_m):
    return fuse_depth([view_of(depth_m)], voxel_m=0.01, far_m=2.0, kind=SurfaceKind.MEASURED)


def test_a_wall_comes_out_where_it_stands():
    mesh = fused(np.full((HEIGHT, WIDTH), 0.8))
    assert mesh is not None
    off_m = mesh.vertices_world[:, 2] - 0.8
    assert np.abs(off_m).max() < 0.01
    assert len(mesh.triangles) > 1000


# Open3D looks at every fourth pixel, and only at whole fours: it ends where it finds nothing there.
@pytest.mark.parametrize("pixel", [(1, 1), (6, 7), (62, 40), (20, 81)])
def test_depth_that_open3d_does_not_look_at_is_no_surface(pixel):
    depth_m = np.full((HEIGHT, WIDTH), np.nan)
    depth_m[pixel] = 0.8
    assert fused(depth_m) is None


def test_depth_beyond_the_reach_is_no_surface():
    assert fused(np.full((HEIGHT, WIDTH), 3.0)) is None
