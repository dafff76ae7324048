"""Two things that fit the same words: the gaze decides, or it is said that it does not."""

import dataclasses

import numpy as np
import pytest

from grounding.pipeline import ground_session
from grounding.plan import GroundedInstruction, Status
from grounding.types import FixationObservation, FloatArray
from services.bench.glide import SceneConfig, draw_scene

APART_M = np.array([0.06, 0.0, 0.0])
SIGMA_M = 0.02


def grounded(seed: int, *, decides: bool) -> tuple[GroundedInstruction, str, str]:
    """The first pick of a drawn scene, with a twin beside its thing, and what the two are.

    The looks at the thing go to it alone, or by turns to it and to its twin.
    """
    scene = draw_scene(SceneConfig(pairs=3, things=6, sigma_m=0.01), np.random.default_rng(seed))
    shown = scene.demonstration
    (thing,) = (each for each in shown.objects if each.object_id == scene.things[0])
    place = thing.track[0]
    there = dataclasses.replace(place, position_world=place.position_world + APART_M)
    twin = dataclasses.replace(thing, object_id="twin", track=(there,))
    mine = [k for k, label in enumerate(scene.labels) if label == 0]
    noise = np.random.default_rng(seed).normal(0.0, SIGMA_M, (len(mine), 3)) * [1, 1, 0]
    looks = list(shown.fixations)
    for n, k in enumerate(mine):
        at, off = place.position_world, noise[n]
        if not decides and n == len(mine) - 1 and n % 2 == 0:
            at, off = at + APART_M / 2, np.zeros(3)
        elif not decides and n % 2:  # a mirror of the look before: nothing tells
            at, off = there.position_world, noise[n - 1] * [-1, 1, 0]
        looks[k] = look(looks[k], at + off)
    plan = ground_session(
        dataclasses.replace(shown, fixations=looks, objects=[*shown.objects, twin]), name="twins"
    ).plan
    return plan.instructions[0], thing.object_id, twin.object_id


def look(before: FixationObservation, at: FloatArray) -> FixationObservation:
    cov = np.diag([SIGMA_M**2, SIGMA_M**2, 1e-6])
    return dataclasses.replace(before, point_world=at, cov_world=cov)


@pytest.mark.parametrize("seed", range(2))
def test_a_gaze_that_does_not_decide_leaves_both_as_candidates(seed: int) -> None:
    said, thing, twin = grounded(seed, decides=False)
    shares = {each.object_id: each.probability for each in said.candidates}
    assert said.status is Status.AMBIGUOUS
    assert (said.target, said.location) == (None, None)
    assert said.question == f"Which one is the {' '.join(said.spoken.instruction.target)}?"
    assert min(shares[thing], shares[twin]) > 0.05
    assert shares[thing] + shares[twin] > 0.8
    assert said.confidence < 0.95


@pytest.mark.parametrize("seed", range(2))
def test_a_gaze_that_decides_is_believed(seed: int) -> None:
    said, thing, _ = grounded(seed, decides=True)
    assert said.status is Status.GROUNDED
    assert said.target is not None
    assert said.target.object_id == thing
