"""A head that looks down on a table and gaze samples of points on it."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gazemap.geometry.camera import Camera
from gazemap.types.tracking import Scale, Trajectory


@pytest.fixture
def camera() -> Camera:
    K = np.array([[560.0, 0, 400], [0, 560, 300], [0, 0, 1]])
    return Camera(width_px=800, height_px=600, K=K, distortion=np.array([-0.1, 0.05, 0, 0]))


@pytest.fixture
def trajectory() -> Trajectory:
    """Sway by some centimetres and degrees over six seconds, 30 poses a second."""
    t_s = np.arange(0, 6, 1 / 30)
    down = Rotation.from_euler("x", -130, degrees=True)
    sway_deg = np.column_stack([6 * np.sin(1.5 * t_s), 3 * np.cos(t_s)])
    turn = Rotation.from_euler("zx", sway_deg, degrees=True)
    position = np.column_stack(
        [0.08 * np.sin(1.2 * t_s), -0.6 + 0.03 * np.cos(t_s), 0.5 + 0.01 * np.sin(2 * t_s)]
    )
    return Trajectory(
        t_ns=(t_s * 1e9).astype(np.int64),
        quat_xyzw=(down * turn).as_quat(),
        p_world_cam=position,
        scale=Scale.METRIC,
    )
