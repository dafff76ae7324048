"""The rig that watches the drawn tabletop."""

import numpy as np
import pytest

from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Pose
from tests.drawn_tabletop import Rig, looking_at


@pytest.fixture
def head_camera() -> Camera:
    K = np.array([[560.0, 0, 400], [0, 560, 300], [0, 0, 1]])
    return Camera(width_px=800, height_px=600, K=K, distortion=np.array([-0.12, 0.08, 0, 0]))


@pytest.fixture
def overhead_camera() -> Camera:
    K = np.array([[820.0, 0, 480], [0, 820, 360], [0, 0, 1]])
    return Camera(width_px=960, height_px=720, K=K, distortion=np.zeros(0))


@pytest.fixture
def T_world_overhead() -> Pose:
    return looking_at(np.array([0.05, -0.1, 1.25]), np.array([0.0, 0.0, 0.0]))


@pytest.fixture
def rig(head_camera: Camera, overhead_camera: Camera, T_world_overhead: Pose) -> Rig:
    return Rig(
        head_camera=head_camera,
        overhead_camera=overhead_camera,
        T_world_overhead=T_world_overhead,
    )
