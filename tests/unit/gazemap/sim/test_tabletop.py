"""The plan of a demonstration and where things are while it goes on."""

import numpy as np
import pytest

from gazemap.errors import ConfigError
from gazemap.sim.config import Level, SimConfig, TabletopConfig, preset
from gazemap.sim.tabletop import Action, Demonstration, demonstrate
from gazemap.sim.vocabulary import Relation

SEEDS = range(12)


def demonstration(seed: int, **changes) -> Demonstration:
    return demonstrate(SimConfig(seconds=40.0, **changes), np.random.default_rng(seed))


@pytest.mark.parametrize("seed", SEEDS)
def test_picks_and_puts_alternate_and_fill_the_session(seed: int) -> None:
    steps = demonstration(seed).steps
    assert [step.action for step in steps] == [Action.PICK, Action.PUT] * (len(steps) // 2)
    assert 10 <= len(steps) <= 16
    starts, ends = np.array([step.start_s for step in steps]), np.array([s.end_s for s in steps])
    assert (starts[1:] >= ends[:-1] - 1e-9).all()
    assert 36.0 < ends[-1] < 38.5


@pytest.mark.parametrize("seed", SEEDS)
def test_things_never_stand_in_one_another(seed: int) -> None:
    story = demonstration(seed)
    for step in story.steps[1::2]:
        centres = story.centres_world(step.end_s)
        for i, a in enumerate(story.blocks):
            for j, b in enumerate(story.blocks[:i]):
                apart = np.abs(centres[i] - centres[j])
                stacked = apart[2] >= (a.size_m[2] + b.size_m[2]) / 2 - 1e-9
                radii = np.hypot(*a.size_m[:2]) / 2 + np.hypot(*b.size_m[:2]) / 2
                assert stacked or np.hypot(*apart[:2]) > radii


@pytest.mark.parametrize("seed", SEEDS)
def test_a_thing_is_put_on_the_side_that_is_said(seed: int) -> None:
    story = demonstration(seed)
    for step in story.steps[1::2]:
        reference = story.centres_world(step.start_s)[step.reference]
        way = step.position_world - reference
        said = {
            Relation.LEFT_OF: way[0] < -0.05,
            Relation.RIGHT_OF: way[0] > 0.05,
            Relation.IN_FRONT_OF: way[1] < -0.05,
            Relation.BEHIND: way[1] > 0.05,
            Relation.ON_TOP_OF: way[2] > 0.01 and np.hypot(*way[:2]) < 1e-9,
        }
        assert said[step.relation]
        assert step.relation.value.replace("-", " ") in step.sentence


def test_carried_thing_goes_smoothly_over_the_table() -> None:
    story = demonstration(1)
    carry = story.carries[0]
    t_s = np.linspace(carry.lift_s - 0.1, carry.release_s + 0.1, 400)
    path = np.array([story.centres_world(t)[carry.block] for t in t_s])
    assert np.allclose(path[0], carry.from_world)
    assert np.allclose(path[-1], carry.to_world)
    assert 0.15 < path[:, 2].max() < 0.25
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() < 0.03


def test_only_the_words_asked_for_are_used() -> None:
    tabletop = TabletopConfig(
        colours=("green", "orange"), shapes=("brick", "pillar"), object_count=4,
        relations=(Relation.BEHIND,),
    )  # fmt: skip
    story = demonstration(3, tabletop=tabletop)
    assert {block.words for block in story.blocks} == {
        (c, s) for c in tabletop.colours for s in tabletop.shapes
    }
    assert {step.relation for step in story.steps[1::2]} == {Relation.BEHIND}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"colours": ("mauve",)}, "mauve"),
        ({"shapes": ("sphere",)}, "sphere"),
        ({"object_count": 1}, "object_count 1"),
        ({"relations": ()}, "relation"),
    ],
)
def test_words_that_cannot_be_drawn_are_refused(changes, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        TabletopConfig(**changes)


def test_levels_get_harder() -> None:
    easy, medium, hard = (preset(level) for level in Level)
    assert not easy.person.has_hand
    assert medium.person.has_hand
    assert easy.person.gaze_offset_deg < medium.person.gaze_offset_deg < hard.person.gaze_offset_deg
    assert easy.imaging.readout_s == medium.imaging.readout_s == 0.0 < hard.imaging.readout_s
