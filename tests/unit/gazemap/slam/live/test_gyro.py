import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gazemap.geometry.pose import Pose
from gazemap.slam.live.gyro import Gyroscope, solve_mounting
from gazemap.slam.live.motion import Motion
from gazemap.types.session import ImuSample

R_CAM_IMU = Rotation.from_euler("xyz", [85, -10, 170], degrees=True).as_matrix()
BIAS = np.array([0.02, -0.05, 0.01])
FRAME_NS = 33_333_333


def camera_rate(t_s):
    """Return how the camera turns, in its own frame, rad/s."""
    return np.array([0.5 * np.sin(2.1 * t_s), 0.8 * np.cos(1.3 * t_s), 0.3 * np.sin(3.1 * t_s)])


def run(seconds, *, noise=0.01, wrong=False, rate_hz=200):
    """Return a motion that has followed a turning camera, its gyroscope and the time."""
    rng = np.random.default_rng(0)
    gyroscope = Gyroscope()
    R_world_cam = Rotation.identity()
    motion = Motion(Pose.identity(), 0, gyroscope)
    next_sample = 0
    for frame in range(1, int(seconds * 30)):
        t_ns = frame * FRAME_NS
        while next_sample <= t_ns:
            rate = R_CAM_IMU.T @ camera_rate(next_sample * 1e-9) + BIAS
            rate = rng.normal(0, 1, 3) if wrong else rate + rng.normal(0, noise, 3)
            gyroscope.add(
                ImuSample(t_ns=next_sample, gyro_rad_s=tuple(rate), accel_m_s2=(0.0, 0.0, 9.8))
            )
            next_sample += int(1e9 / rate_hz)
        for part in range(10):
            at_s = (t_ns - FRAME_NS + (part + 0.5) * FRAME_NS / 10) * 1e-9
            R_world_cam = R_world_cam * Rotation.from_rotvec(camera_rate(at_s) * FRAME_NS * 1e-10)
        motion.observe(Pose(R=R_world_cam.as_matrix().T, t=np.zeros(3)), t_ns)
    return motion, gyroscope, t_ns


def test_mounting_and_bias_are_found_from_the_turns():
    _, gyroscope, _ = run(5)
    off = Rotation.from_matrix(gyroscope.mounting.R_cam_imu @ R_CAM_IMU.T).magnitude()
    assert off < np.radians(1.0)
    assert gyroscope.mounting.bias_imu == pytest.approx(BIAS, abs=0.01)


def test_a_turn_that_begins_suddenly_is_predicted():
    motion, gyroscope, t_ns = run(5)
    before = motion.T_cam_world
    for n in range(1, 41):
        rate = R_CAM_IMU.T @ [0.0, 3.0, 0.0] + BIAS
        gyroscope.add(
            ImuSample(t_ns=t_ns + n * 5_000_000, gyro_rad_s=tuple(rate), accel_m_s2=(0, 0, 0))
        )
    turned = motion.predict(t_ns + 200_000_000).R @ before.R.T
    angle = Rotation.from_matrix(turned).as_rotvec()
    assert angle == pytest.approx([0.0, -0.6, 0.0], abs=0.06)


def test_a_gyroscope_that_contradicts_the_camera_is_not_used():
    _, gyroscope, t_ns = run(5, wrong=True)
    assert gyroscope.mounting is None
    assert gyroscope.turn_rate(t_ns - FRAME_NS, t_ns) is None


def test_turns_about_one_axis_leave_the_mounting_open():
    rng = np.random.default_rng(1)
    cam = np.outer(rng.normal(0, 1, 100), [0, 1, 0]) + rng.normal(0, 0.01, (100, 3))
    assert solve_mounting(np.stack([cam @ R_CAM_IMU, cam], axis=1)) is None


def test_a_gap_in_the_samples_gives_no_rate():
    motion, gyroscope, t_ns = run(5)
    gyroscope.add(ImuSample(t_ns=t_ns + 10**9, gyro_rad_s=(0, 0, 0), accel_m_s2=(0, 0, 0)))
    assert gyroscope.turn_rate(t_ns, t_ns + 10**9) is None
    assert np.allclose(motion.predict(t_ns + 10**9).R, motion.T_cam_world.R)
