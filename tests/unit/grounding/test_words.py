import cv2
import numpy as np

from grounding.glide.read import Candidate, Spot
from grounding.patches.patch import Patch
from grounding.plan import GroundedInstruction, GroundedPlan, Status
from grounding.symbols.records import SymbolConfig
from grounding.symbols.session import learn_from_patches
from grounding.types import Action, Instruction, SpokenInstruction
from grounding.words import heed_words

BGR = {"red": (40, 35, 200), "blue": (190, 70, 40), "yellow": (40, 200, 235)}


def instruction(index: int, colour: str, *, status: Status) -> GroundedInstruction:
    spot = Spot(position_world=np.zeros(3), cov_world=np.eye(3) * 1e-6, probability=1.0)
    target = Candidate(object_id=f"object-{index}", spot=spot, quat_xyzw=None, size_m=None)
    return GroundedInstruction(
        spoken=SpokenInstruction(
            index=index,
            sentence=f"pick up the {colour} cube",
            instruction=Instruction(
                action=Action.PICK, target=(colour, "cube"), location=f"{colour}-cube-location"
            ),
            said_start_ns=None,
            said_end_ns=None,
        ),
        start_ns=index,
        end_ns=index + 1,
        status=status,
        confidence=0.99,
        target=target if status is Status.GROUNDED else None,
        location=spot if status is Status.GROUNDED else None,
    )


def pictures(index: int, *, said: str, shown: str) -> list[Patch]:
    rng = np.random.default_rng(index)
    patches = []
    for k in range(6):
        image = np.full((60, 60, 3), (110, 140, 170), np.uint8)
        shift = rng.integers(-2, 3)
        cv2.rectangle(image, (18 + shift, 18), (42 + shift, 42), BGR[shown], -1)
        noisy = image.astype(float) + rng.normal(0, 4, image.shape)
        patches.append(
            Patch(
                name=f"{index}-{k}.png",
                camera="overhead",
                t_ns=k,
                uv_px=np.zeros(2),
                instruction=index,
                symbols=(said, "cube"),
                weight=0.99,
                image_bgr=np.clip(noisy, 0, 255).astype(np.uint8),
                mm_per_px=1.0,
                height_mm=24.0,
                object_id=f"object-{index}",
                rejection=None,
            )
        )
    return patches


def heeded(said: list[str], shown: list[str]) -> list[GroundedInstruction]:
    pairs = list(zip(said, shown, strict=True))
    patches = [p for i, (a, b) in enumerate(pairs) for p in pictures(i, said=a, shown=b)]
    plan = GroundedPlan(
        session="words",
        revision=1,
        scale="metric",
        instructions=tuple(instruction(i, a, status=Status.GROUNDED) for i, a in enumerate(said)),
    )
    symbols = learn_from_patches(patches, SymbolConfig())
    return list(heed_words(plan, patches, symbols).instructions)


COLOURS = ["red", "blue", "yellow"] * 3


def test_words_that_agree_leave_the_plan_alone() -> None:
    assert {each.status for each in heeded(COLOURS, COLOURS)} == {Status.GROUNDED}


def test_a_target_that_looks_like_another_word_is_not_sure() -> None:
    shown = [*COLOURS[:-1], "blue"]  # the last was called yellow
    plan = heeded(COLOURS, shown)
    assert [each.status for each in plan[:-1]] == [Status.GROUNDED] * 8
    assert plan[-1].status is Status.AMBIGUOUS
    assert plan[-1].question == "Is this one 'yellow'? It looks like 'blue' to me."


def test_a_word_that_other_things_do_not_look_like_either_contradicts_nothing() -> None:
    shown = [*COLOURS[:-4], "blue", *COLOURS[-3:-1], "blue"]  # two of three yellow ones
    assert {each.status for each in heeded(COLOURS, shown)} == {Status.GROUNDED}


def test_a_word_that_nobody_has_shown_becomes_a_question() -> None:
    patches = [p for i, c in enumerate(COLOURS) for p in pictures(i, said=c, shown=c)]
    plan = GroundedPlan(
        session="words",
        revision=1,
        scale="metric",
        instructions=(instruction(9, "mauve", status=Status.UNGROUNDED),),
    )
    (asked,) = heed_words(plan, patches, learn_from_patches(patches, SymbolConfig())).instructions
    assert asked.status is Status.UNKNOWN_SYMBOL
    assert asked.question == "What does 'mauve' mean? Please show me one."
