"""A relation that was shown five times is understood for other things and other places."""

import dataclasses
from functools import cache

import numpy as np
import pytest

from gazemap.sim.config import SimConfig, TabletopConfig
from gazemap.sim.tabletop import Demonstration, Step, demonstrate
from gazemap.sim.vocabulary import Relation
from grounding.plan import Status
from grounding.query import NamedThing, PresentScene, ground_sentence
from grounding.relations import Body, Demonstrated, wearer_axes
from grounding.types import Action, Instruction, ObjectInstance, RestingPlace, SpokenInstruction

HEADINGS_RAD = [0.0, 2.0]
SEEN, ASKED = range(5), range(100, 150)


@cache
def drawn(seed: int, relation: Relation) -> tuple[Demonstration, Step]:
    """The first thing that a simulated person puts somewhere, on a table of its own."""
    config = SimConfig(tabletop=TabletopConfig(relations=(relation,)))
    shown = demonstrate(config, np.random.default_rng(seed))
    return shown, next(step for step in shown.steps if step.relation is not None)


def body(shown: Demonstration, block: int, at: np.ndarray, *, heading_rad: float = 0.0) -> Body:
    """A thing, the whole table turned about z with its wearer."""
    turned = wearer_axes(heading_rad).T @ at
    return Body(position_world=turned, size_m=shown.blocks[block].size_m)


def demonstrated(seed: int, relation: Relation, heading_rad: float) -> Demonstrated:
    shown, put = drawn(seed, relation)
    assert put.reference is not None
    before = shown.centres_world(put.start_s)
    return Demonstrated(
        relation=relation.value,
        thing=body(shown, put.block, put.position_world, heading_rad=heading_rad),
        landmark=body(shown, put.reference, before[put.reference], heading_rad=heading_rad),
        heading_rad=heading_rad,
    )


def thing(number: int, words: tuple[str, ...], at: Body) -> NamedThing:
    rest = RestingPlace(
        t_ns=0,
        left_ns=None,
        position_world=at.position_world,
        quat_xyzw=np.array([0.0, 0.0, 0.0, 1.0]),
        cov_world=np.eye(3) * 1e-6,
    )
    return NamedThing(
        instance=ObjectInstance(object_id=f"object-{number}", size_m=at.size_m, track=(rest,)),
        words=dict.fromkeys(words, 0.95),
    )


def scene(
    shown: Demonstration, at_s: float, seen: list[Demonstrated], *, heading_rad: float = 0.0
) -> PresentScene:
    centres = shown.centres_world(at_s)
    things = [
        thing(i, block.words, body(shown, i, centres[i], heading_rad=heading_rad))
        for i, block in enumerate(shown.blocks)
    ]
    words = frozenset(word for block in shown.blocks for word in block.words)
    return PresentScene(things=things, known_words=words, seen=seen, heading_rad=heading_rad)


def asked(target: tuple[str, ...], location: str, among: PresentScene) -> np.ndarray:
    """Where a new sentence says the thing goes; with nothing shown the answer says so."""
    spoken = SpokenInstruction(
        index=0,
        sentence="",
        instruction=Instruction(action=Action.PLACE, target=target, location=location),
        said_start_ns=None,
        said_end_ns=None,
    )
    answer = ground_sentence(spoken, among)
    assert answer.status is Status.GROUNDED, answer.reason
    assert answer.location is not None
    assert (answer.reason is not None) == (not among.seen)
    return answer.location.position_world


def error_m(
    seed: int, relation: Relation, seen: list[Demonstrated], heading_rad: float = 0.0
) -> float:
    """How far the answer to a new sentence is from where the simulated person puts the thing."""
    shown, put = drawn(seed, relation)
    assert put.reference is not None
    other = shown.blocks[put.reference].words
    location = "-".join([relation.phrase.replace("the ", "").replace(" ", "-"), *other])
    among = scene(shown, put.start_s, seen, heading_rad=heading_rad)
    goal = asked(shown.blocks[put.block].words, location, among)
    there = wearer_axes(heading_rad).T @ put.position_world
    return float(np.linalg.norm(goal - there))


@pytest.mark.parametrize("heading_rad", HEADINGS_RAD)
@pytest.mark.parametrize("relation", list(Relation))
def test_five_demonstrations_are_enough(relation: Relation, heading_rad: float) -> None:
    seen = [demonstrated(seed, relation, heading_rad) for seed in SEEN]
    errors = np.array([error_m(seed, relation, seen, heading_rad) for seed in ASKED])
    assert np.mean(errors < 0.04) >= 0.9


def test_no_demonstration_uses_the_built_in_meaning_and_says_so() -> None:
    errors = [error_m(100 + seed, Relation.LEFT_OF, []) for seed in range(20)]
    assert 0.001 < np.median(errors) < 0.06


@pytest.mark.parametrize("seen_count", [0, 5])
@pytest.mark.parametrize("heading_rad", HEADINGS_RAD)
def test_between_two_things_is_where_a_person_puts_it(seen_count: int, heading_rad: float) -> None:
    def put(seed: int) -> tuple[PresentScene, Body, Body, np.ndarray]:
        shown, _ = drawn(seed, Relation.BEHIND)
        among = scene(shown, 0.0, [], heading_rad=heading_rad)
        one, other, mine = (each.body for each in among.things[:3])
        middle = (one.position_world + other.position_world) / 2
        there = np.append(middle[:2], mine.size_m[2] / 2)
        there[:2] += np.random.default_rng(seed).normal(0.0, 0.01, 2)
        about = Body(position_world=middle, size_m=(one.size_m + other.size_m) / 2)
        return among, Body(position_world=there, size_m=mine.size_m), about, there

    seen = [
        Demonstrated(relation="between", thing=mine, landmark=about, heading_rad=heading_rad)
        for _, mine, about, _ in map(put, range(seen_count))
    ]
    errors = []
    for seed in ASKED:
        among, _, _, there = put(seed)
        names = ["-".join(each.words) for each in among.things[:2]]
        location = f"between-{names[0]}-and-{names[1]}"
        target = tuple(among.things[2].words)
        goal = asked(target, location, dataclasses.replace(among, seen=seen))
        errors.append(float(np.linalg.norm(goal - there)))
    assert np.mean(np.array(errors) < 0.04) >= 0.9
    assert np.median(errors) > 0.004  # the person is not exact


@pytest.mark.parametrize("seen_count", [0, 5])
def test_in_a_box_is_on_its_bottom(seen_count: int) -> None:
    tray = Body(position_world=np.array([0.2, 0.1, 0.03]), size_m=np.array([0.18, 0.14, 0.06]))

    def put(seed: int) -> tuple[Demonstration, np.ndarray]:
        shown, _ = drawn(seed, Relation.BEHIND)
        off = np.random.default_rng(seed).normal(0.0, 0.015, 2)
        height = shown.blocks[0].size_m[2] / 2 + 0.004
        return shown, np.append(tray.position_world[:2] + off, height)

    seen = [
        Demonstrated(relation="in", thing=body(shown, 0, there), landmark=tray)
        for shown, there in map(put, range(seen_count))
    ]
    errors = []
    for seed in ASKED:
        shown, there = put(seed)
        among = scene(shown, 0.0, seen)
        among = dataclasses.replace(
            among,
            things=[*among.things, thing(99, ("tray",), tray)],
            known_words=among.known_words | {"tray"},
        )
        goal = asked(shown.blocks[0].words, "in-tray", among)
        errors.append(float(np.linalg.norm(goal - there)))
    assert np.mean(np.array(errors) < 0.04) >= 0.9


@pytest.mark.parametrize("gap_m", [0.02, 0.07])
def test_near_is_as_near_as_was_shown_with_room_and_on_the_table(gap_m: float) -> None:
    rng = np.random.default_rng(0)

    def beside(shown: Demonstration, angle: float) -> Demonstrated:
        mine, other = body(shown, 0, np.zeros(3)), body(shown, 1, np.zeros(3))
        apart = gap_m + mine.reach_m[0] + other.reach_m[0]
        at = apart * np.array([np.cos(angle), np.sin(angle), 0.0])
        return Demonstrated(relation="near", thing=body(shown, 0, at), landmark=other)

    seen = [beside(drawn(s, Relation.BEHIND)[0], rng.uniform(0, 2 * np.pi)) for s in SEEN]
    right = []
    for seed in ASKED:
        shown, _ = drawn(seed, Relation.BEHIND)
        among = scene(shown, 0.0, seen)
        target, landmark = (each.body for each in among.things[:2])
        goal = asked(shown.blocks[0].words, "near-" + "-".join(shown.blocks[1].words), among)
        off = float(np.linalg.norm(goal[:2] - landmark.position_world[:2]))
        gap = off - target.reach_m[0] - landmark.reach_m[0]
        free = min(
            float(np.linalg.norm(goal[:2] - each.body.position_world[:2]))
            - each.body.reach_m[0]
            - target.reach_m[0]
            for each in among.things[2:]
        )
        on_table = bool((np.abs(goal[:2]) < [0.62, 0.42]).all())
        right.append(abs(gap - gap_m) < 0.04 and free > 0.0 and on_table)
    assert np.mean(right) >= 0.9


def test_a_relation_without_a_meaning_is_asked_for_until_it_was_shown() -> None:
    shown, _ = drawn(1, Relation.BEHIND)
    words, other = shown.blocks[0].words, "-".join(shown.blocks[1].words)
    spoken = SpokenInstruction(
        index=0,
        sentence="",
        instruction=Instruction(action=Action.PLACE, target=words, location=f"across-from-{other}"),
        said_start_ns=None,
        said_end_ns=None,
    )
    answer = ground_sentence(spoken, scene(shown, 0.0, []))
    assert (answer.status, answer.location) == (Status.UNKNOWN_SYMBOL, None)
    assert answer.question == "Where is 'opposite'? Please show me."
    landmark = body(shown, 1, shown.centres_world(0.0)[1])
    offset = np.array([0.0, 0.3, 0.0])
    seen = [
        Demonstrated(
            relation="opposite",
            thing=dataclasses.replace(landmark, position_world=landmark.position_world + offset),
            landmark=landmark,
        )
    ] * 5
    answer = ground_sentence(spoken, scene(shown, 0.0, seen))
    assert answer.status is Status.GROUNDED
    assert answer.location is not None
    assert 0.2 < answer.location.position_world[1] - landmark.position_world[1] < 0.31
