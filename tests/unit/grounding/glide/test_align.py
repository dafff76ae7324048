import numpy as np

from grounding.glide.align import align
from grounding.glide.model import Demonstration
from grounding.types import (
    Action,
    FixationObservation,
    Instruction,
    ObjectInstance,
    RestingPlace,
    SpokenInstruction,
)

EYE = np.array([0.0, -0.6, 0.6])


def look(number: int, at: np.ndarray, *, start_s: float) -> FixationObservation:
    return FixationObservation(
        fixation_id=number,
        start_ns=int(start_s * 1e9),
        end_ns=int((start_s + 0.3) * 1e9),
        point_world=at,
        cov_world=np.eye(3) * 0.01**2,
        origin_world=EYE,
    )


def thing(number: int, *places: tuple[float, float | None, np.ndarray]) -> ObjectInstance:
    return ObjectInstance(
        object_id=f"object-{number}",
        size_m=np.full(3, 0.04),
        track=tuple(
            RestingPlace(
                t_ns=int(t * 1e9),
                left_ns=None if left is None else int(left * 1e9),
                position_world=at,
                quat_xyzw=np.array([0.0, 0.0, 0.0, 1.0]),
                cov_world=np.eye(3) * 0.002**2,
            )
            for t, left, at in places
        ),
    )


def said(index: int, action: Action, location: str = "red-cube-location") -> SpokenInstruction:
    return SpokenInstruction(
        index=index,
        sentence="",
        instruction=Instruction(action=action, target=("red", "cube"), location=location),
        said_start_ns=None,
        said_end_ns=None,
    )


A, B = np.array([-0.2, 0.0, 0.02]), np.array([0.2, 0.1, 0.02])
STRAY = [np.array([0.35, -0.2, 0.02]), np.array([-0.3, 0.25, 0.02])]
POINTS = [STRAY[0], *[A] * 5, *[B] * 5, STRAY[1]]
LOOKS = [look(i, at, start_s=0.35 * i) for i, at in enumerate(POINTS)]
PLAN = [said(0, Action.PICK), said(1, Action.PLACE, "on-table")]


def labels(*objects: ObjectInstance) -> list[int | None]:
    alignment = align(Demonstration(spoken=PLAN, fixations=LOOKS, objects=objects))
    return [each.instruction for each in alignment.looks]


def test_looks_are_labelled_by_the_action_they_serve() -> None:
    cube = thing(0, (0.0, 2.0, A), (3.8, None, B))
    other = thing(1, (0.0, None, np.array([0.0, 0.3, 0.02])))
    assert labels(cube, other) == [None, *[0] * 5, *[1] * 5, None]


def test_gaze_alone_labels_the_same_looks() -> None:
    assert labels() == [None, *[0] * 5, *[1] * 5, None]


def test_gaze_alone_finds_the_target_within_a_centimetre() -> None:
    alignment = align(Demonstration(spoken=PLAN, fixations=LOOKS, table_height=0.0))
    spot = alignment.instructions[0].candidates[0].spot
    assert np.linalg.norm(spot.position_world - A) < 0.01
    assert 0.001 < np.sqrt(spot.cov_world[0, 0]) < 0.02


def test_nothing_said_labels_nothing() -> None:
    alignment = align(Demonstration(spoken=[], fixations=LOOKS))
    assert {each.instruction for each in alignment.looks} == {None}
