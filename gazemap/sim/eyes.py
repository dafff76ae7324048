"""Where the person looks: fixations on what the hand will need next, and some elsewhere."""

from dataclasses import dataclass

import numpy as np

from gazemap.geometry.arrays import FloatArray
from gazemap.sim.config import PersonConfig
from gazemap.sim.tabletop import Action, Demonstration
from gazemap.sim.vocabulary import Relation

_MEDIAN_S, _LOG_SIGMA = 0.31, 0.42
_SHORTEST_S, _LONGEST_S = 0.12, 1.1
_SACCADE_S = (0.030, 0.060)
_SPREAD_M = np.array([0.0045, 0.0045, 0.0013])  # where on a thing it is looked at
_SEEN_HALF_M = np.array([0.42, 0.33])
_IDLE_ON_THING_SHARE = 0.25


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Look:
    """One fixation: a point (3,) in world; instruction is the step's index, None for none."""

    start_s: float
    end_s: float
    point_world: FloatArray
    instruction: int | None


def look_around(
    demonstration: Demonstration,
    config: PersonConfig,
    *,
    seconds: float,
    rng: np.random.Generator,
) -> tuple[Look, ...]:
    """Draw the fixations of a whole session, one after another."""
    looks: list[Look] = []
    t_s = 0.0
    while t_s < seconds - _SHORTEST_S:
        lasts_s = _MEDIAN_S * float(np.exp(rng.normal(0.0, _LOG_SIGMA)))
        end_s = min(t_s + float(np.clip(lasts_s, _SHORTEST_S, _LONGEST_S)), seconds)
        instruction = _step_at(demonstration, t_s)
        if instruction is not None and rng.random() < config.stray_share:
            instruction = None
        if instruction is None:
            point = _anywhere(demonstration, t_s, rng)
        else:
            point = _on_purpose(demonstration, instruction, config=config, rng=rng)
        looks.append(Look(start_s=t_s, end_s=end_s, point_world=point, instruction=instruction))
        t_s = end_s + float(rng.uniform(*_SACCADE_S))
    return tuple(looks)


def _step_at(demonstration: Demonstration, t_s: float) -> int | None:
    for i, step in enumerate(demonstration.steps):
        if step.start_s <= t_s < step.end_s:
            return i
    return None


def _on_purpose(
    demonstration: Demonstration, i: int, *, config: PersonConfig, rng: np.random.Generator
) -> FloatArray:
    """Look at the thing to grasp, or at the place where it goes and what it goes next to."""
    step = demonstration.steps[i]
    centre = step.position_world
    beside = step.action is Action.PUT and step.relation is not Relation.ON_TOP_OF
    if beside and step.reference is not None and rng.random() < config.reference_share:
        centre = demonstration.centres_world(step.start_s)[step.reference]
    return centre + rng.normal(0.0, _SPREAD_M)


def _anywhere(demonstration: Demonstration, t_s: float, rng: np.random.Generator) -> FloatArray:
    if rng.random() < _IDLE_ON_THING_SHARE:
        centres = demonstration.centres_world(t_s)
        chosen: FloatArray = centres[int(rng.integers(len(centres)))]
        return chosen + rng.normal(0.0, _SPREAD_M)
    return np.array([*(rng.uniform(-1.0, 1.0, 2) * _SEEN_HALF_M), 0.0])
