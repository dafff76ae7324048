import numpy as np

from grounding.relations import (
    Body,
    Demonstrated,
    goal_of,
    learn_relation,
)

CUBE = np.full(3, 0.04)


def put(offset: list[float]) -> Demonstrated:
    landmark = Body(position_world=np.array([0.1, 0.2, 0.02]), size_m=CUBE)
    thing = Body(position_world=landmark.position_world + offset, size_m=CUBE)
    return Demonstrated(relation="left-of", thing=thing, landmark=landmark)


def test_without_demonstrations_the_prior_says_so() -> None:
    assert learn_relation("left-of", []).is_prior
    assert not learn_relation("left-of", [put([-0.1, 0.0, 0.0])]).is_prior


def test_demonstrations_pull_the_mean_and_shrink_the_spread() -> None:
    prior = learn_relation("left-of", [])
    learnt = learn_relation("left-of", [put([-0.14, 0.0, 0.0])] * 20)
    assert abs(learnt.mean_m[0] + 0.10) < 0.005  # 0.14 less two halves of 0.02
    assert learnt.cov_m2[0, 0] < prior.cov_m2[0, 0]


def test_left_turns_with_the_wearer() -> None:
    landmark = Body(position_world=np.zeros(3), size_m=CUBE)
    relation = learn_relation("left-of", [])
    thing = landmark
    ahead, _ = goal_of(relation, "left-of", thing=thing, landmarks=[landmark])
    turned, _ = goal_of(
        relation, "left-of", thing=thing, landmarks=[landmark], heading_rad=np.pi / 2
    )
    assert ahead[0] < -0.05
    assert abs(ahead[1]) < 1e-9
    assert turned[1] < -0.05
    assert abs(turned[0]) < 1e-9


def test_a_thing_on_top_rests_on_its_landmark() -> None:
    low = Body(position_world=np.array([0.0, 0.0, 0.01]), size_m=np.array([0.03, 0.03, 0.02]))
    tall = Body(position_world=np.zeros(3), size_m=np.array([0.03, 0.03, 0.06]))
    relation = learn_relation("on-top-of", [])
    goal, _ = goal_of(relation, "on-top-of", thing=tall, landmarks=[low])
    assert np.allclose(goal, [0.0, 0.0, 0.05])
