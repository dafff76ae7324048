"""When a belief becomes a grounded instruction, and when it is taken back."""

import numpy as np
import pytest

from grounding.glide.align import Alignment
from grounding.glide.read import Candidate, InstructionBelief, Spot
from grounding.plan import GroundedPlan, PlanConfig, Status, ground_instructions
from grounding.types import Action, Instruction, SpokenInstruction

SPOKEN = SpokenInstruction(
    index=0,
    sentence="pick up the red cube",
    instruction=Instruction(
        action=Action.PICK, target=("red", "cube"), location="red-cube-location"
    ),
    said_start_ns=None,
    said_end_ns=None,
)


def candidate(name: str, probability: float) -> Candidate:
    spot = Spot(position_world=np.zeros(3), cov_world=np.eye(3) * 0.003**2, probability=probability)
    return Candidate(object_id=name, spot=spot, quat_xyzw=None, size_m=None)


def plan(probability: float, *, name: str = "a", before: GroundedPlan | None) -> GroundedPlan:
    """The plan of one instruction whose target is this thing with this probability."""
    belief = InstructionBelief(
        index=0,
        start_ns=0,
        end_ns=1,
        done=1.0,
        looks=4.0,
        candidates=(candidate(name, probability), candidate("other", 1 - probability)),
        moves=False,
        location=None,
        landmark=None,
        over=1.0,
        fixation_ids=(1,),
    )
    alignment = Alignment(
        looks=(), instructions=(belief,), log_evidence=0.0, fit=1.0, parameters=None
    )
    found = ground_instructions([SPOKEN], alignment, PlanConfig(), open_end=True, before=before)
    return GroundedPlan(session="", revision=1, scale="metric", instructions=found)


def status(found: GroundedPlan) -> Status:
    return found.instructions[0].status


def test_what_was_grounded_stays_while_its_belief_wavers_and_goes_when_the_evidence_turns() -> None:
    sure = plan(0.97, before=None)
    assert status(sure) is Status.GROUNDED
    wavering = plan(0.9, before=sure)
    assert status(wavering) is Status.GROUNDED
    assert wavering.instructions[0].confidence == pytest.approx(0.9)
    assert status(plan(0.9, before=None)) is Status.AMBIGUOUS
    assert status(plan(0.7, before=wavering)) is Status.AMBIGUOUS


def test_another_thing_is_grounded_only_where_it_is_sure_itself() -> None:
    sure = plan(0.97, before=None)
    assert status(plan(0.9, name="b", before=sure)) is Status.AMBIGUOUS
    assert status(plan(0.97, name="b", before=sure)) is Status.GROUNDED
