"""The scoring that is shared with the project reads what the simulator writes."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from tests.builders import SimulatedSession

SCORE = Path(__file__).resolve().parents[3].parent / "shared" / "score" / "score.py"


@pytest.fixture
def world(small_session: SimulatedSession):
    if not SCORE.exists():
        pytest.skip("no shared/score/score.py")
    spec = importlib.util.spec_from_file_location("score", SCORE)
    score = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(score)
    return score.World(small_session.truth)


def test_score_moves_the_things_as_they_were_drawn(world, small_session: SimulatedSession) -> None:
    story = small_session.script.demonstration
    for t_s in np.linspace(0.0, small_session.script.config.seconds, 60):
        centres = np.array([matrix[:3, 3] for matrix in world.objects(t_s)])
        assert np.abs(centres - story.centres_world(t_s)).max() < 1e-9


def test_score_ends_where_the_truth_ends(world) -> None:
    for matrix, thing in zip(world.end, world.truth["objects"], strict=True):
        assert np.abs(matrix - np.array(thing["end"])).max() < 1e-9


def test_score_finds_the_place_that_was_said(world, small_session: SimulatedSession) -> None:
    for row, step in zip(
        world.truth["plan"], small_session.script.demonstration.steps, strict=True
    ):
        location = world.location(row)
        if step.relation is None:
            assert location == "-".join(row["target"]) + "-location"
        else:
            assert location.replace("-", " ") in step.sentence.replace("the ", "")


def test_score_meets_the_fixated_points(world) -> None:
    errors = []
    for fixation in world.truth["fixations"]:
        middle_s = world.seconds((fixation["start_ns"] + fixation["end_ns"]) // 2)
        hit = world.hit_point(middle_s, fixation["point"])
        assert hit is not None
        errors.append(np.linalg.norm(hit - fixation["point"]))
    # Points within a thing are met on its surface.
    assert np.median(errors) < 0.05
