import dataclasses

import numpy as np
import pytest

from grounding.glide.align import Alignment
from grounding.glide.model import Demonstration
from grounding.glide.windows import align_session
from grounding.types import SpokenInstruction
from services.bench.glide import Scene, SceneConfig, draw_scene


def exchanged(spoken: list[SpokenInstruction], first: int) -> list[SpokenInstruction]:
    """The pair that begins at `first` and the one after it, said the other way round."""
    order = list(range(len(spoken)))
    order[first : first + 4] = [first + 2, first + 3, first, first + 1]
    return [
        dataclasses.replace(
            spoken[i], said_start_ns=spoken[k].said_start_ns, said_end_ns=spoken[k].said_end_ns
        )
        for k, i in enumerate(order)
    ]


def sure_and_wrong(alignment: Alignment, things: dict[int, str]) -> int:
    return sum(
        each.candidates[0].probability > 0.95 and each.candidates[0].object_id != things[each.index]
        for each in alignment.instructions
    )


def drawn(seed: int, *, times: bool) -> tuple[Scene, dict[int, str]]:
    config = SceneConfig(motion=True, times=times)
    scene = draw_scene(config, np.random.default_rng(seed))
    return scene, dict(enumerate(scene.things))


@pytest.mark.parametrize("times", [False, True])
@pytest.mark.parametrize("first", [0, 2, 4])
def test_pairs_done_in_another_order_are_in_doubt(first: int, *, times: bool) -> None:
    scene, things = drawn(1, times=times)
    spoken = exchanged(list(scene.demonstration.spoken), first)
    alignment = align_session(dataclasses.replace(scene.demonstration, spoken=spoken))
    assert sure_and_wrong(alignment, things) == 0


def test_another_order_is_understood_where_what_else_was_said_tells() -> None:
    # "Left of the flat thing" says where the flat thing stands: a name said as a landmark before
    # and after the exchanged pairs.
    scene, things = drawn(0, times=False)
    spoken = exchanged(list(scene.demonstration.spoken), 2)
    alignment = align_session(dataclasses.replace(scene.demonstration, spoken=spoken))
    assert [each.index for each in alignment.instructions] == [each.index for each in spoken]
    for each in alignment.instructions:
        assert each.candidates[0].object_id == things[each.index]
    labels = zip(alignment.looks, scene.labels, strict=True)
    assert np.mean([look.instruction == true for look, true in labels]) > 0.9


def test_what_was_not_spoken_of_is_left_alone() -> None:
    scene, things = drawn(1, times=True)
    spoken = [each for each in scene.demonstration.spoken if each.index not in {2, 3}]
    alignment = align_session(dataclasses.replace(scene.demonstration, spoken=spoken))
    assert [each.candidates[0].object_id for each in alignment.instructions] == [
        things[each.index] for each in spoken
    ]
    labels = zip(alignment.looks, scene.labels, strict=True)
    unsaid = [look.instruction for look, true in labels if true in {2, 3}]
    assert np.mean([label is None for label in unsaid]) > 0.8


def test_which_of_three_pairs_was_meant_stays_open_without_times() -> None:
    scene, things = drawn(3, times=False)
    spoken = [
        dataclasses.replace(
            each,
            instruction=dataclasses.replace(
                each.instruction, location="-".join(each.instruction.target) + "-location"
            ),
        )
        for each in scene.demonstration.spoken
        if each.index in {2, 3}
    ]
    alignment = align_session(dataclasses.replace(scene.demonstration, spoken=spoken))
    assert sure_and_wrong(alignment, things) == 0


def test_the_order_as_said_is_kept_where_it_fits() -> None:
    scene, things = drawn(2, times=False)
    alignment = align_session(scene.demonstration)
    assert [each.index for each in alignment.instructions] == list(things)
    assert [each.candidates[0].object_id for each in alignment.instructions] == list(
        things.values()
    )
    assert min(each.candidates[0].probability for each in alignment.instructions) > 0.95


def test_a_correction_moves_with_its_instruction() -> None:
    scene, things = drawn(0, times=False)
    spoken = exchanged(list(scene.demonstration.spoken), 2)
    told = Demonstration(
        spoken=spoken,
        fixations=scene.demonstration.fixations,
        objects=scene.demonstration.objects,
        table_height=0.0,
        meant={2: things[spoken[2].index]},
    )
    alignment = align_session(told)
    assert alignment.instructions[2].candidates[0].object_id == things[spoken[2].index]
