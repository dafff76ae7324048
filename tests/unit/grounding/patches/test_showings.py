import numpy as np

from grounding.glide.read import Candidate, Spot
from grounding.patches.cut import PatchConfig, Showing
from grounding.patches.showings import showings_of
from grounding.plan import GroundedInstruction, GroundedPlan, Status
from grounding.types import (
    Action,
    FixationObservation,
    Instruction,
    ObjectInstance,
    RestingPlace,
    SpokenInstruction,
)

LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
COV = np.eye(3) * 1e-6
HOME, TABLE = np.array([-0.2, 0.0, 0.02]), np.array([0.2, 0.0, 0.02])
STACKED = TABLE + np.array([0.0, 0.0, 0.04])


def rest(since_s: float, left_s: float | None, at: np.ndarray) -> RestingPlace:
    left_ns = None if left_s is None else int(left_s * 1e9)
    return RestingPlace(
        t_ns=int(since_s * 1e9), left_ns=left_ns, position_world=at, quat_xyzw=LEVEL, cov_world=COV
    )


def thing(number: int, *track: RestingPlace) -> ObjectInstance:
    return ObjectInstance(object_id=f"object-{number}", size_m=np.full(3, 0.04), track=track)


def shown(goal: np.ndarray, *others: ObjectInstance) -> Showing:
    """A cube is taken from home at 5 s and put at the goal at 7 s; the session lasts 12 s."""
    cube = thing(0, rest(0, 5, HOME), rest(7, None, goal))
    spot = Spot(position_world=HOME, cov_world=COV, probability=1.0)
    put = GroundedInstruction(
        spoken=SpokenInstruction(
            index=0,
            sentence="put the cube there",
            instruction=Instruction(action=Action.PLACE, target=("cube",), location="on-table"),
            said_start_ns=None,
            said_end_ns=None,
        ),
        start_ns=int(5e9),
        end_ns=int(7e9),
        status=Status.GROUNDED,
        confidence=1.0,
        target=Candidate(object_id="object-0", spot=spot, quat_xyzw=LEVEL, size_m=cube.size_m),
        location=Spot(position_world=goal, cov_world=COV, probability=1.0),
        fixations=(0,),
    )
    looks = [
        FixationObservation(
            fixation_id=k, start_ns=int(s * 1e9), end_ns=int((s + 0.5) * 1e9), point_world=goal,
            cov_world=np.eye(3) * 1e-4,
        )
        for k, s in ((0, 6.0), (1, 0.0), (2, 11.5))
    ]  # fmt: skip
    plan = GroundedPlan(session="s", revision=1, scale="metric", instructions=(put,))
    (showing,) = showings_of(plan, [cube, *others], looks, PatchConfig())
    return showing


def test_what_was_put_on_the_table_is_pictured_there_afterwards() -> None:
    showing = shown(TABLE, thing(1, rest(0, None, np.array([0.3, 0.1, 0.02]))))
    assert np.allclose(showing.position_world, TABLE)
    assert int(7e9) < showing.since_ns < showing.until_ns == int(12e9)
    assert showing.is_looked_at


def test_what_was_stacked_is_pictured_before_alone() -> None:
    showing = shown(STACKED, thing(1, rest(0, None, TABLE)))
    assert np.allclose(showing.position_world, HOME)
    assert 0 <= showing.since_ns < showing.until_ns < int(5e9)


def test_what_has_something_put_on_it_later_is_pictured_until_then() -> None:
    showing = shown(
        TABLE, thing(1, rest(0, 9, HOME + np.array([0, 0.3, 0])), rest(10, None, STACKED))
    )
    assert np.allclose(showing.position_world, TABLE)
    assert showing.until_ns == int(10e9)
