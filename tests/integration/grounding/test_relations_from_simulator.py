"""A relation that was shown five times is understood for other things and other places."""

import numpy as np
import pytest

from gazemap.sim.config import SimConfig, TabletopConfig
from gazemap.sim.tabletop import Demonstration, Step, demonstrate
from gazemap.sim.vocabulary import Relation
from grounding.plan import Status
from grounding.query import NamedThing, PresentScene, ground_sentence
from grounding.relations import Body, Demonstrated
from grounding.types import Action, Instruction, ObjectInstance, RestingPlace, SpokenInstruction


def drawn(seed: int, relation: Relation) -> tuple[Demonstration, Step]:
    """The first thing that a simulated person puts somewhere, on a table of its own."""
    config = SimConfig(tabletop=TabletopConfig(relations=(relation,)))
    shown = demonstrate(config, np.random.default_rng(seed))
    return shown, next(step for step in shown.steps if step.relation is not None)


def body(shown: Demonstration, block: int, at: np.ndarray) -> Body:
    return Body(position_world=at, size_m=shown.blocks[block].size_m)


def demonstrated(seed: int, relation: Relation) -> Demonstrated:
    shown, put = drawn(seed, relation)
    assert put.reference is not None
    before = shown.centres_world(put.start_s)
    return Demonstrated(
        relation=relation.value,
        thing=body(shown, put.block, put.position_world),
        landmark=body(shown, put.reference, before[put.reference]),
    )


def scene(shown: Demonstration, at_s: float, seen: list[Demonstrated]) -> PresentScene:
    things = [
        NamedThing(
            instance=ObjectInstance(
                object_id=f"object-{i}",
                size_m=block.size_m,
                track=(
                    RestingPlace(
                        t_ns=0,
                        left_ns=None,
                        position_world=centre,
                        quat_xyzw=np.array([0.0, 0.0, 0.0, 1.0]),
                        cov_world=np.eye(3) * 1e-6,
                    ),
                ),
            ),
            words=dict.fromkeys(block.words, 0.95),
        )
        for i, (block, centre) in enumerate(
            zip(shown.blocks, shown.centres_world(at_s), strict=True)
        )
    ]
    words = frozenset(word for block in shown.blocks for word in block.words)
    return PresentScene(things=things, known_words=words, seen=seen)


def error_m(seed: int, relation: Relation, seen: list[Demonstrated]) -> float:
    """How far the answer to a new sentence is from where the simulated person puts the thing."""
    shown, put = drawn(seed, relation)
    assert put.reference is not None
    target, other = shown.blocks[put.block].words, shown.blocks[put.reference].words
    location = "-".join([relation.phrase.replace("the ", "").replace(" ", "-"), *other])
    spoken = SpokenInstruction(
        index=0,
        sentence=put.sentence,
        instruction=Instruction(action=Action.PLACE, target=tuple(target), location=location),
        said_start_ns=None,
        said_end_ns=None,
    )
    answer = ground_sentence(spoken, scene(shown, put.start_s, seen))
    assert answer.status is Status.GROUNDED, answer.reason
    assert answer.location is not None
    assert (answer.reason is not None) == (not seen)
    return float(np.linalg.norm(answer.location.position_world - put.position_world))


@pytest.mark.parametrize("relation", [Relation.LEFT_OF, Relation.BEHIND, Relation.ON_TOP_OF])
def test_five_demonstrations_are_enough(relation: Relation) -> None:
    seen = [demonstrated(seed, relation) for seed in range(5)]
    errors = np.array([error_m(100 + seed, relation, seen) for seed in range(50)])
    assert np.mean(errors < 0.04) >= 0.9


def test_no_demonstration_uses_the_built_in_meaning_and_says_so() -> None:
    errors = [error_m(100 + seed, Relation.LEFT_OF, []) for seed in range(20)]
    assert 0.001 < np.median(errors) < 0.06
