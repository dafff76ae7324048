"""Sessions with a drawn gaze error, noise, rate and level: is what is said about gaze true?"""

import importlib.util
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

from gazemap.pipeline import MappingConfig, find_looks, locate_cameras, model_scene
from gazemap.scene.config import SceneConfig, SweepConfig
from gazemap.session import open_session
from gazemap.sim.config import Level, preset, resized
from tests.builders import build_session

SCORE = Path(__file__).resolve().parents[3].parent / "shared" / "score" / "score.py"
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not SCORE.exists(), reason="shared/score/score.py is not there"),
]
LEVELS = [Level.EASY, Level.MEDIUM, Level.HARD]
# The surroundings do not matter to what is on the table, and cost the most.
CONFIG = MappingConfig(scene=SceneConfig(sweep=SweepConfig(pool=1)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """One session: which looks lay inside their 95 % ellipsoids, and the degrees left."""

    is_inside: list[bool]
    left_deg: float


def silent(stage, done, total):
    """Take a report and do nothing."""


def drawn(n):
    rng = np.random.default_rng([31, n])
    config = preset(LEVELS[n % 3])
    person = replace(
        config.person,
        gaze_offset_deg=float(rng.uniform(0.0, 3.0)),
        gaze_noise_deg=float(rng.uniform(0.1, 0.6)),
    )
    return replace(
        config,
        seed=7000 + n,
        seconds=14.0,
        gaze_rate_hz=float(rng.choice([30, 60, 120, 200])),
        person=person,
        scene_lens=resized(config.scene_lens, width_px=640, height_px=480, rate_hz=20.0),
    )


def world(truth):
    spec = importlib.util.spec_from_file_location("score", SCORE)
    score = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(score)
    return score.World(truth)


def outcome(n, folder):
    simulated = build_session(folder, drawn(n))
    session = open_session(simulated.session)
    located = locate_cameras(session, CONFIG, progress=silent)
    scene = model_scene(session, located, CONFIG, progress=silent)
    looks = find_looks(session, located, scene, CONFIG)
    true, focal_px = world(simulated.truth), located.slam.camera.K[0, 0]
    given = np.array([looks.offset.azimuth_rad, looks.offset.elevation_rad])
    bias_rad = np.array(true.truth["gaze_bias_px"]) / focal_px * [1, -1]
    left = bias_rad - given * looks.offset.is_applied
    cast = {look.fixation.fixation_id: look for look in looks.fixations}
    inside = [is_inside(true, f, cast[f["id"]]) for f in true.truth["fixations"] if f["id"] in cast]
    return Outcome(
        is_inside=[each for each in inside if each is not None],
        left_deg=float(np.degrees(np.linalg.norm(left))),
    )


def is_inside(true, fixation, look):
    middle_ns = (fixation["start_ns"] + fixation["end_ns"]) // 2
    point = true.hit_point(true.seconds(middle_ns), fixation["point"])
    if point is None or look.point_world is None:
        return None
    away = look.point_world - point
    return bool(away @ np.linalg.solve(look.cov_world, away) < chi2.ppf(0.95, 3))


@pytest.fixture(scope="module")
def outcomes(tmp_path_factory):
    return [outcome(n, tmp_path_factory.mktemp(f"drawn-{n}")) for n in range(6)]


def test_ellipsoids_hold_what_they_promise(outcomes):
    inside = np.concatenate([each.is_inside for each in outcomes])
    assert len(inside) > 150
    assert 0.90 < inside.mean() < 0.985


def test_little_of_the_gaze_error_is_left(outcomes):
    left = [each.left_deg for each in outcomes]
    assert 0.01 < np.median(left) < 0.5
