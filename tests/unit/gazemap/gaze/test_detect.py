import numpy as np
import pytest

from gazemap.gaze.config import FixationConfig, FixationMethod
from gazemap.gaze.detect import detect_fixations
from gazemap.types.session import Blink, GazeSamples

POINTS = np.array([[0.0, 0.0, 0], [0.2, 0.05, 0], [0.19, 0.055, 0], [-0.2, 0.1, 0], [0.0, -0.1, 0]])
STARTS_S = np.array([0.2, 1.0, 1.7, 2.5, 3.4])
ENDS_S = np.array([0.95, 1.66, 2.45, 3.35, 4.2])


def gaze_on(points, camera, trajectory, *, noise_deg, seed=1) -> GazeSamples:
    t_ns = (np.arange(STARTS_S[0], ENDS_S[-1], 0.005) * 1e9).astype(np.int64)
    rng = np.random.default_rng(seed)
    knots_s = np.column_stack([STARTS_S, ENDS_S]).ravel()
    at = np.column_stack(
        [np.interp(t_ns * 1e-9, knots_s, np.repeat(points[:, k], 2)) for k in range(3)]
    )
    poses = [trajectory.at(int(t)) for t in t_ns]
    uv = [camera.project(p.inverse().transform(x[None]))[0] for p, x in zip(poses, at, strict=True)]
    uv_px = np.array(uv) + rng.normal(0, np.radians(noise_deg) * 560, (len(t_ns), 2))
    return GazeSamples(
        t_ns=t_ns, uv_px=uv_px, worn=np.ones(len(t_ns), bool), blink=np.zeros(len(t_ns), bool)
    )


def overlap(fixation, start_s, end_s) -> float:
    inside = min(fixation.end_ns * 1e-9, end_s) - max(fixation.start_ns * 1e-9, start_s)
    return inside / (max(fixation.end_ns * 1e-9, end_s) - min(fixation.start_ns * 1e-9, start_s))


@pytest.mark.parametrize("noise_deg", [0.1, 0.3, 0.5])
def test_fixations_are_found_while_the_head_moves(camera, trajectory, noise_deg):
    gaze = gaze_on(POINTS, camera, trajectory, noise_deg=noise_deg)
    found = detect_fixations(gaze, camera, trajectory, (), FixationConfig())
    assert len(found) == 5  # the second and third lie 0.8 degrees apart
    for fixation, start_s, end_s in zip(found, STARTS_S, ENDS_S, strict=True):
        assert overlap(fixation, start_s, end_s) > 0.8


def test_a_long_look_is_one_although_its_point_is_thought_too_far(camera, trajectory):
    """What stands 4 cm above the table drifts by tenths of a degree while the head sways."""
    point = np.array([0.05, 0.1, 0.04])
    gaze = gaze_on(np.tile(point, (5, 1)), camera, trajectory, noise_deg=0.03)
    found = detect_fixations(gaze, camera, trajectory, (), FixationConfig())
    assert len(found) <= 2
    assert sum(f.end_ns - f.start_ns for f in found) > 3.6e9


def test_small_steps_that_noise_hides_are_told_by_the_usual_length_of_rests(camera, trajectory):
    """Thirty samples a second, half a degree of noise, steps of 1.1 degrees."""
    points = POINTS[0] + np.array([[0, 0, 0], [0.016, 0, 0], [0, 0, 0], [0.016, 0, 0], [0, 0, 0]])
    gaze = gaze_on(points, camera, trajectory, noise_deg=0.5)
    slow = GazeSamples(
        t_ns=gaze.t_ns[::7], uv_px=gaze.uv_px[::7], worn=gaze.worn[::7], blink=gaze.blink[::7]
    )
    found = detect_fixations(slow, camera, trajectory, (), FixationConfig())
    pairs = zip(STARTS_S, ENDS_S, strict=True)
    right = [max(overlap(f, start, end) for f in found) > 0.5 for start, end in pairs]
    assert sum(right) >= 4


def test_a_fixations_pixel_is_where_the_point_lay_at_mid_time(camera, trajectory):
    gaze = gaze_on(POINTS, camera, trajectory, noise_deg=0.3)
    found = detect_fixations(gaze, camera, trajectory, (), FixationConfig())
    for fixation, point in zip(found, POINTS, strict=True):
        T_world_cam = trajectory.at(fixation.mid_ns)
        expected = camera.project(T_world_cam.inverse().transform(point[None]))[0]
        assert np.linalg.norm([fixation.u_px, fixation.v_px] - expected) < 1.5


def test_dispersion_finds_the_same_large_steps(camera, trajectory):
    gaze = gaze_on(POINTS[[0, 1, 1, 3, 4]], camera, trajectory, noise_deg=0.1)
    config = FixationConfig(method=FixationMethod.DISPERSION)
    found = detect_fixations(gaze, camera, trajectory, (), config)
    assert any(overlap(f, STARTS_S[3], ENDS_S[3]) > 0.8 for f in found)


def test_a_blink_is_no_part_of_a_fixation(camera, trajectory):
    gaze = gaze_on(POINTS, camera, trajectory, noise_deg=0.2)
    blink = Blink(start_ns=2_700_000_000, end_ns=3_000_000_000)
    found = detect_fixations(gaze, camera, trajectory, (blink,), FixationConfig())
    assert all(f.end_ns <= blink.start_ns or f.start_ns >= blink.end_ns for f in found)
    assert max(overlap(f, STARTS_S[3], 2.7) for f in found) > 0.8
    assert max(overlap(f, 3.0, ENDS_S[3]) for f in found) > 0.8


@pytest.mark.parametrize(("blink_s", "parts"), [(0.12, 1), (0.2, 1), (0.3, 2)])
def test_a_look_goes_on_after_a_short_blink(camera, trajectory, blink_s, parts):
    gaze = gaze_on(POINTS, camera, trajectory, noise_deg=0.2)
    blink = Blink(start_ns=1_300_000_000, end_ns=1_300_000_000 + int(blink_s * 1e9))
    found = detect_fixations(gaze, camera, trajectory, (blink,), FixationConfig())
    assert sum(overlap(f, STARTS_S[1], ENDS_S[1]) > 0.05 for f in found) == parts


def test_a_blink_on_the_way_to_another_thing_is_not_bridged(camera, trajectory):
    gaze = gaze_on(POINTS, camera, trajectory, noise_deg=0.2)
    blink = Blink(start_ns=880_000_000, end_ns=1_080_000_000)
    found = detect_fixations(gaze, camera, trajectory, (blink,), FixationConfig())
    assert max(overlap(f, STARTS_S[0], 0.88) for f in found) > 0.8
    assert max(overlap(f, 1.08, ENDS_S[1]) for f in found) > 0.8


def test_nothing_is_found_where_the_glasses_were_off(camera, trajectory):
    gaze = gaze_on(POINTS, camera, trajectory, noise_deg=0.2)
    off = GazeSamples(t_ns=gaze.t_ns, uv_px=gaze.uv_px, worn=~gaze.worn, blink=gaze.blink)
    assert detect_fixations(off, camera, trajectory, (), FixationConfig()) == ()


def test_the_same_samples_give_the_same_fixations(camera, trajectory):
    gaze = gaze_on(POINTS, camera, trajectory, noise_deg=0.4)
    runs = [detect_fixations(gaze, camera, trajectory, (), FixationConfig()) for _ in range(2)]
    assert runs[0] == runs[1]
