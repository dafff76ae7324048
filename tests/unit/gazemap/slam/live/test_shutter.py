import numpy as np
import pytest

from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Pose
from gazemap.slam.live.refine import PoseProblem, refine_pose
from gazemap.slam.live.shutter import ShutterWatch

K = [[500, 0, 319.5], [0, 500, 239.5], [0, 0, 1]]


def watched(readout_s, *, told=None, frames=120, noise_px=0.3, outliers=0.0):
    """Return what a watch finds in frames of a camera that turns and moves."""
    rng = np.random.default_rng(0)
    camera = Camera(width_px=640, height_px=480, K=K, distortion=[], readout_s=told)
    watch = ShutterWatch(camera)
    for _ in range(frames):
        twist = np.concatenate([rng.normal(0, 0.5, 3), rng.normal(0, 0.2, 3)])
        points = rng.uniform([-0.7, -0.5, 1], [0.7, 0.5, 2], (120, 3))
        v_px = camera.project(points)[:, 1]
        delay_s = (v_px / 479 - 0.5) * readout_s
        later = points + delay_s[:, None] * (np.cross(twist[:3], points) + twist[3:])
        uv_px = camera.project(later) + rng.normal(0, noise_px, (120, 2))
        wrong = rng.random(120) < outliers
        uv_px[wrong] += rng.normal(0, 5, (int(wrong.sum()), 2))
        problem = PoseProblem(
            points_world=points,
            xy=camera.normalize(uv_px),
            sigma=np.full(120, 0.3 / 500),
            dt_s=watch.camera.row_delay_ns(uv_px[:, 1]) * 1e-9,
            twist=twist,
        )
        fit = refine_pose(Pose.identity(), problem)
        watch.observe(fit.T_cam_world, problem, uv_px[:, 1])
    return watch.camera.readout_s


@pytest.mark.parametrize("readout_s", [0.03, 0.012])
def test_an_untold_read_out_time_is_found(readout_s):
    found = watched(readout_s, outliers=0.1)
    assert found == pytest.approx(readout_s, abs=0.002)


def test_a_global_shutter_stays_one():
    assert watched(0.0, outliers=0.1) is None


def test_a_told_read_out_time_is_believed():
    assert watched(0.03, told=0.01) == 0.01
