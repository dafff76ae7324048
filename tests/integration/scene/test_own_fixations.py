"""Our own fixations against those of simulated demonstrations, of which nothing is filmed."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gazemap.gaze.config import FixationConfig, FixationMethod
from gazemap.gaze.detect import detect_fixations
from gazemap.sim.config import Level, preset
from gazemap.sim.simulate import write_script
from gazemap.types.session import Blink, Fixation, GazeSamples
from gazemap.types.tracking import Scale, Trajectory

SEEDS = range(5)
FRAME_S = 1.0 / 30.0
ONE_LOOK_DEG, ONE_LOOK_NS = 1.0, 80_000_000


def ns(t_s):
    return np.round(np.asarray(t_s) * 1e9).astype(np.int64)


def path_of(script) -> Trajectory:
    t_s = np.arange(0.0, script.config.seconds, FRAME_S)
    R, centres = script.head.poses(t_s)
    quat_xyzw = Rotation.from_matrix(R).as_quat()
    return Trajectory(t_ns=ns(t_s), quat_xyzw=quat_xyzw, p_world_cam=centres, scale=Scale.METRIC)


def true_looks(script) -> tuple[Fixation, ...]:
    looks = zip(script.looks, script.eyes.looks_px.tolist(), strict=True)
    return tuple(
        Fixation(
            fixation_id=n, start_ns=int(ns(a.start_s)), end_ns=int(ns(a.end_s)), u_px=u, v_px=v
        )
        for n, (a, (u, v)) in enumerate(looks)
    )


def merged(fixations, camera):
    """Return start and end of looks; neighbours that no scene image tells apart are one."""
    looks = []
    for each in fixations:
        at = camera.normalize(np.array([[each.u_px, each.v_px]]))[0]
        if looks and each.start_ns - looks[-1][1] < ONE_LOOK_NS:
            apart_deg = np.degrees(np.linalg.norm(at - looks[-1][2]))
            if apart_deg < ONE_LOOK_DEG:
                looks[-1] = (looks[-1][0], each.end_ns, looks[-1][2])
                continue
        looks.append((each.start_ns, each.end_ns, at))
    return looks


def f1_score(level, seed, config) -> float:
    script = write_script(replace(preset(level), seed=seed))
    eyes, camera = script.eyes, script.scene_camera
    blinks = tuple(Blink(start_ns=int(a), end_ns=int(b)) for a, b in ns(eyes.blinks_s))
    gaze = GazeSamples(
        t_ns=ns(eyes.t_s), uv_px=eyes.uv_px, worn=np.ones(len(eyes.t_s), bool), blink=eyes.blink > 0
    )
    found = merged(detect_fixations(gaze, camera, path_of(script), blinks, config), camera)
    wanted = merged(true_looks(script), camera)
    hits = sum(any(overlap(a, b) >= 0.5 for b in found) for a in wanted)
    return 2.0 * hits / (len(found) + len(wanted))


def overlap(a, b) -> float:
    return (min(a[1], b[1]) - max(a[0], b[0])) / (max(a[1], b[1]) - min(a[0], b[0]))


@pytest.mark.parametrize(("level", "least"), [(Level.EASY, 0.9), (Level.MEDIUM, 0.86)])
def test_looks_are_found_in_sessions_of_these_levels(level, least):
    scores = [f1_score(level, seed, FixationConfig()) for seed in SEEDS]
    assert least < np.mean(scores) < 0.99


def test_dispersion_finds_fewer_of_them():
    """It knows nothing of small saccades, in which gaze hardly spreads."""
    config = FixationConfig(method=FixationMethod.DISPERSION)
    assert 0.45 < np.mean([f1_score(Level.EASY, seed, config) for seed in SEEDS[:2]]) < 0.85
