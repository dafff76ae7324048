"""A drawn demonstration, grounded whole, in part, corrected, and written for other programs."""

import dataclasses
import json
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from grounding.exports import to_behavior_tree, to_json_lines, to_pddl
from grounding.glide.follow import Follower
from grounding.glide.model import Demonstration
from grounding.pipeline import SessionGrounding, ground_session
from grounding.plan import Status
from services.bench.glide import Scene, SceneConfig, draw_scene

INSTRUCTION_KEYS = {
    *("index", "sentence", "action", "target", "location", "start_ns", "end_ns", "status"),
    *("confidence", "object", "target_position", "target_orientation", "target_size"),
    *("target_covariance", "location_position", "location_covariance", "fixations", "patches"),
    *("candidates", "question", "reason"),
}


@pytest.fixture(scope="module")
def scene() -> Scene:
    config = SceneConfig(pairs=2, motion=True, times=True, sigma_m=0.01)
    return draw_scene(config, np.random.default_rng(4))


@pytest.fixture(scope="module")
def grounded(scene: Scene) -> SessionGrounding:
    return ground_session(scene.demonstration, name="drawn")


def so_far(demonstration: Demonstration, looks: int) -> Demonstration:
    """What was said, looked at and seen when so many looks were over."""
    fixations = demonstration.fixations[:looks]
    now = fixations[-1].end_ns
    objects = [
        dataclasses.replace(
            thing,
            track=tuple(
                dataclasses.replace(
                    place,
                    left_ns=place.left_ns if place.left_ns and place.left_ns <= now else None,
                )
                for place in thing.track
                if place.t_ns <= now
            ),
        )
        for thing in demonstration.objects
    ]
    spoken = [each for each in demonstration.spoken if (each.said_start_ns or 0) < now]
    return dataclasses.replace(demonstration, fixations=fixations, objects=objects, spoken=spoken)


def test_every_instruction_is_grounded_in_its_thing(
    scene: Scene, grounded: SessionGrounding
) -> None:
    found = [each.target.object_id if each.target else None for each in grounded.plan.instructions]
    assert tuple(found) == scene.things
    assert {each.status for each in grounded.plan.instructions} == {Status.GROUNDED}


def test_looks_carry_the_instruction_they_serve(scene: Scene, grounded: SessionGrounding) -> None:
    labels = [each.instruction for each in grounded.looks]
    right = np.mean([a == b for a, b in zip(labels, scene.labels, strict=True)])
    assert right >= 0.85


def test_the_plan_has_the_keys_of_the_interface(grounded: SessionGrounding) -> None:
    document = json.loads(json.dumps(grounded.plan.to_json(), allow_nan=False))
    assert set(document) == {
        *("session", "revision", "frame", "scale", "symbols", "unparsed", "instructions"),
    }
    assert set(document["instructions"][0]) == INSTRUCTION_KEYS
    pick, place = document["instructions"][:2]
    assert pick["location_position"] == pick["target_position"]
    assert place["location_position"] != place["target_position"]


def test_an_action_that_has_not_happened_is_left_open(scene: Scene) -> None:
    first_place = scene.labels.index(1)
    early = ground_session(
        so_far(scene.demonstration, first_place + 2), name="drawn", follower=Follower()
    ).plan.instructions
    assert early[0].status is Status.GROUNDED
    assert all(each.status is not Status.GROUNDED for each in early[1:])


def test_the_other_one_replaces_the_target(scene: Scene) -> None:
    other = next(
        thing.object_id
        for thing in scene.demonstration.objects
        if thing.object_id not in scene.things
    )
    told = dataclasses.replace(scene.demonstration, meant={0: other})
    first = ground_session(told, name="drawn").plan.instructions[0]
    assert other in {c.object_id for c in first.candidates} or (
        first.target is not None and first.target.object_id == other
    )
    mine = {c.object_id for c in first.candidates} | {first.target and first.target.object_id}
    assert scene.things[0] not in mine


def test_a_gaze_that_fits_nothing_grounds_nothing(scene: Scene) -> None:
    away = [
        dataclasses.replace(each, point_world=None, cov_world=None)
        for each in scene.demonstration.fixations
    ]
    blind = dataclasses.replace(scene.demonstration, fixations=away)
    plan = ground_session(blind, name="drawn").plan
    assert {each.status for each in plan.instructions} == {Status.UNGROUNDED}
    assert plan.instructions[0].to_json()["target_position"] is None


def test_json_lines_hold_one_instruction_each(grounded: SessionGrounding) -> None:
    lines = [json.loads(line) for line in to_json_lines(grounded.plan).splitlines()]
    assert [line["index"] for line in lines] == [0, 1, 2, 3]
    assert set(lines[0]) == {"session", "revision", *INSTRUCTION_KEYS}


def test_a_behaviour_tree_picks_and_places_in_order(grounded: SessionGrounding) -> None:
    root = ET.fromstring(to_behavior_tree(grounded.plan))  # noqa: S314 (our own output)
    nodes = [node.get("ID") for node in root.findall("BehaviorTree/Sequence/Action")]
    assert root.get("BTCPP_format") == "4"
    assert nodes == ["Pick", "Place", "Pick", "Place"]


def test_pddl_states_words_and_goals_with_balanced_parentheses(
    scene: Scene, grounded: SessionGrounding
) -> None:
    text = to_pddl(grounded.plan)
    assert text.count("(") == text.count(")")
    assert f"(is-thing {scene.things[0]})" in text
    assert f"(at {scene.things[1]} place-1)" in text.split("(:goal")[1]


def test_a_gaze_of_other_times_is_not_believed() -> None:
    rng = np.random.default_rng(7)
    drawn = draw_scene(SceneConfig(motion=True, times=True, sigma_m=0.01), rng)
    looks = drawn.demonstration.fixations
    order = rng.permutation(len(looks))
    shuffled = [
        dataclasses.replace(each, point_world=looks[k].point_world, cov_world=looks[k].cov_world)
        for each, k in zip(looks, order, strict=True)
    ]
    grounded = ground_session(
        dataclasses.replace(drawn.demonstration, fixations=shuffled), name="shuffled"
    )
    pairs = zip(grounded.looks, drawn.labels, strict=True)
    right = [look.instruction == label for look, label in pairs if label is not None]
    assert np.mean(right) < 0.4
    assert all(each.status is not Status.GROUNDED for each in grounded.plan.instructions)


def test_what_was_said_and_not_done_is_not_grounded(scene: Scene) -> None:
    said = list(scene.demonstration.spoken)
    more = dataclasses.replace(
        said[0].instruction, target=("green", "ball"), location="green-ball-location"
    )
    said.insert(2, dataclasses.replace(said[0], instruction=more, said_start_ns=None))
    said = [dataclasses.replace(each, index=i) for i, each in enumerate(said)]
    plan = ground_session(
        dataclasses.replace(scene.demonstration, spoken=said), name="drawn"
    ).plan.instructions
    assert plan[2].status is not Status.GROUNDED
    assert [plan[i].status for i in (0, 1, 3, 4)] == [Status.GROUNDED] * 4


def test_an_arbitrary_scale_changes_no_label() -> None:
    config = SceneConfig(pairs=2, sigma_m=0.01, times=True)
    drawn = draw_scene(config, np.random.default_rng(11))
    eye = np.array([0.0, -0.5, 0.5])

    def grounded(factor: float, scale: str) -> list[int | None]:
        looks = [
            dataclasses.replace(
                each,
                point_world=factor * each.point_world,
                cov_world=factor**2 * each.cov_world,
                origin_world=factor * eye,
            )
            for each in drawn.demonstration.fixations
            if each.point_world is not None and each.cov_world is not None
        ]
        shown = dataclasses.replace(drawn.demonstration, fixations=looks, objects=[])
        return [x.instruction for x in ground_session(shown, name="s", scale=scale).looks]

    assert grounded(7.3, "arbitrary") == grounded(1.0, "arbitrary")
