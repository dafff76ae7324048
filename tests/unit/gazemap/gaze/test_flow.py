"""The motion of the image from optic flow, against a camera that turned before a drawn scene."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gazemap.gaze.config import FixationConfig
from gazemap.gaze.detect import detect_fixations
from gazemap.gaze.flow import ImageMotion, image_motion
from gazemap.types.frame import Frame
from gazemap.types.session import GazeSamples

COUNT = 60
T_NS = (np.arange(COUNT) / 30 * 1e9).astype(np.int64)


def truth(rate_deg_s: float = 12.0) -> Rotation:
    t_s = T_NS * 1e-9
    angles = np.column_stack([rate_deg_s * t_s, 4 * np.sin(3 * t_s)])
    return Rotation.from_euler("yx", angles, degrees=True)


def rendered(camera, R_world_cam: Rotation, blank: tuple[int, ...] = ()) -> list[Frame]:
    """Draw noise on a sphere: turning is all that changes the image."""
    rng = np.random.default_rng(4)
    sphere = cv2.GaussianBlur(rng.integers(0, 256, (720, 1440)).astype(np.uint8), (0, 0), 2)
    sphere = cv2.normalize(sphere, None, 0, 255, cv2.NORM_MINMAX)
    v, u = np.mgrid[: camera.height_px, : camera.width_px].astype(float)
    rays_cam = camera.unproject(np.column_stack([u.ravel(), v.ravel()]))
    frames = []
    for i, R in enumerate(R_world_cam):
        x, y, z = R.apply(rays_cam).T
        at_u = (np.arctan2(x, z) / (2 * np.pi) + 0.5) * 1440
        at_v = (np.arcsin(y) / np.pi + 0.5) * 720
        shape = (camera.height_px, camera.width_px)
        maps = (at_u.reshape(shape).astype(np.float32), at_v.reshape(shape).astype(np.float32))
        image = np.zeros(shape, np.uint8) if i in blank else cv2.remap(sphere, *maps, 1)
        frames.append(Frame(index=i, t_ns=int(T_NS[i]), image=image))
    return frames


def off_deg(motion: ImageMotion, t_ns: np.ndarray, R_true: Rotation) -> float:
    """Return the largest angle between where a few rays were moved to, and should have been."""
    rays = np.array([[0.0, 0, 1], [0.2, 0.1, 1], [-0.2, 0.15, 1]])
    H, _ = motion.at(t_ns)
    moved = np.linalg.inv(H[-1]) @ H @ rays.T  # (N, 3, K) as the last image has them
    expected = np.array([(R_true[-1].inv() * R).as_matrix() @ rays.T for R in R_true])
    moved, expected = (a / np.linalg.norm(a, axis=1, keepdims=True) for a in (moved, expected))
    return float(np.degrees(np.linalg.norm(moved - expected, axis=1)).max())


@pytest.fixture
def small(camera):
    return replace(camera, width_px=400, height_px=300, K=camera.K * [[0.5], [0.5], [1]])


def test_steps_sum_up_to_the_turn_of_the_head(small):
    R_true = truth()
    none = np.zeros(COUNT, bool)
    motion = image_motion(iter(rendered(small, R_true)), T_NS, small, is_posed=none)
    assert set(motion.reference) == {0}
    assert off_deg(motion, T_NS, R_true) < 0.5


def test_blank_frames_part_what_comes_before_from_what_comes_after(small):
    frames, none = rendered(small, truth(), blank=tuple(range(28, 34))), np.zeros(COUNT, bool)
    motion = image_motion(iter(frames), T_NS, small, is_posed=none)
    _, reference = motion.at(T_NS)
    assert reference[10] >= 0
    assert reference[50] >= 0
    assert reference[10] != reference[50]
    assert set(reference[29:33]) == {-1}


def test_frames_with_poses_are_followed_only_beside_those_without(small):
    is_posed = np.arange(COUNT) < 55
    motion = image_motion(iter(rendered(small, truth())), T_NS, small, is_posed=is_posed)
    assert motion.t_ns[0] == T_NS[25]  # a second before
    assert motion.t_ns[-1] == T_NS[-1]


def test_a_path_without_gaps_needs_no_images(small):
    def unwanted():
        pytest.fail("a frame was asked for")
        yield

    assert image_motion(unwanted(), T_NS, small, is_posed=np.ones(COUNT, bool)) is None


def test_a_held_point_is_one_fixation_while_the_head_turns_without_poses(small):
    R_true = truth(rate_deg_s=20.0)
    t_ns = (np.arange(0.1, 1.8, 0.005) * 1e9).astype(np.int64)
    turned = Rotation.from_quat(R_true.as_quat())
    nearest = np.clip(np.searchsorted(T_NS, t_ns), 1, COUNT - 1)
    share = (t_ns - T_NS[nearest - 1]) / (T_NS[nearest] - T_NS[nearest - 1])
    step = (turned[nearest - 1].inv() * turned[nearest]).as_rotvec()
    R_world_cam = turned[nearest - 1] * Rotation.from_rotvec(share[:, None] * step)
    held = np.where((t_ns < 9e8)[:, None], [0.2, 0.0, 0.98], [0.35, 0.1, 0.93])
    noise = np.random.default_rng(2).normal(0, 1.0, (len(t_ns), 2))
    gaze = GazeSamples(
        t_ns=t_ns,
        uv_px=small.project(R_world_cam.inv().apply(held)) + noise,
        worn=np.ones(len(t_ns), bool),
        blink=np.zeros(len(t_ns), bool),
    )
    none = np.zeros(COUNT, bool)
    motion = image_motion(iter(rendered(small, R_true)), T_NS, small, is_posed=none)
    found = detect_fixations(gaze, small, None, (), FixationConfig(), motion=motion)
    spans = [(f.start_ns * 1e-9, f.end_ns * 1e-9) for f in found]
    np.testing.assert_allclose(spans, [(0.1, 0.895), (0.9, 1.795)], atol=0.03)
    without = detect_fixations(gaze, small, None, (), FixationConfig())
    assert len(without) > 2
