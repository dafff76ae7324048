"""Things that are called by one word look alike, in colour or in size."""

import numpy as np
import pytest

from grounding.glide.likeness import log_likeness
from grounding.glide.read import Candidate, InstructionBelief, Spot
from grounding.types import Action, Instruction, ObjectInstance, SpokenInstruction

RED, BLUE = np.array([50.0, 60.0, 40.0]), np.array([40.0, 20.0, -60.0])
CUBE, PLANK = np.array([0.05, 0.05, 0.05]), np.array([0.11, 0.026, 0.014])


def thing(name: str, colour_lab: np.ndarray | None, size_m: np.ndarray) -> ObjectInstance:
    return ObjectInstance(object_id=name, size_m=size_m, track=(), colour_lab=colour_lab)


def log_of(called: list[tuple[str, ObjectInstance]], *, probability: float = 0.9) -> float:
    """Of things that are picked up, each called by some words."""
    spoken, beliefs = [], []
    for i, (words, each) in enumerate(called):
        target = tuple(words.split())
        own = "-".join([*target, "location"])
        spot = Spot(position_world=np.zeros(3), cov_world=np.eye(3), probability=probability)
        candidate = Candidate(object_id=each.object_id, spot=spot, quat_xyzw=None, size_m=None)
        spoken.append(
            SpokenInstruction(
                index=i,
                sentence=words,
                instruction=Instruction(action=Action.PICK, target=target, location=own),
                said_start_ns=None,
                said_end_ns=None,
            )
        )
        beliefs.append(
            InstructionBelief(
                index=i,
                start_ns=0,
                end_ns=1,
                done=1.0,
                looks=3.0,
                candidates=(candidate,),
                moves=False,
                location=None,
                landmark=None,
                over=1.0,
                fixation_ids=(),
            )
        )
    return log_likeness(spoken, beliefs, [each for _, each in called])


def test_one_word_for_two_that_look_alike_speaks_for_it_and_for_two_that_do_not_against() -> None:
    red, plank = thing("a", RED, CUBE), thing("b", RED + 3, PLANK)
    blue = thing("c", BLUE, 1.03 * CUBE)
    assert 0.0 < log_of([("dax one", red), ("dax two", plank)]) < np.log(3)
    assert 0.0 < log_of([("one wug", red), ("two wug", blue)]) < np.log(3)
    assert log_of([("dax one", plank), ("dax two", blue)]) < -2.0


def test_a_word_of_three_things_weighs_as_two() -> None:
    alike = [thing(name, RED, CUBE) for name in "abc"]
    two = log_of([(f"dax {each.object_id}", each) for each in alike[:2]])
    three = log_of([(f"dax {each.object_id}", each) for each in alike])
    assert three == pytest.approx(2 * two)


@pytest.mark.parametrize("probability", [0.4, 0.9])
def test_what_says_nothing_counts_for_nothing(probability: float) -> None:
    unknown, plank = thing("a", None, CUBE), thing("b", None, PLANK)
    log = log_of([("dax one", unknown), ("dax two", plank)], probability=probability)
    assert log == pytest.approx(0.0) if probability < 0.5 else -0.8 < log < 0.0
    assert log_of([("dax one", unknown), ("dax two", unknown)]) == 0.0
    assert log_of([("dax", unknown), ("wug", plank)]) == 0.0
