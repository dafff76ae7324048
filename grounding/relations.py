"""Where a relation says a thing is, and how that is learnt.

A relation is a normal distribution of the free space that is left between a thing and its landmark,
in the wearer's axes (right, forward, up), beyond half their sizes in the relation's direction: so
what was learnt with small things serves for large ones. It starts from a built-in prior and is
learnt from what was seen; with no demonstration the prior is used and says so.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from grounding.types import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Sense:
    """What a relation means before any demonstration.

    Attributes:
        direction: unit vector (right, forward, up) from the landmark; zero for the same place.
        clearance_m: free space in that direction.
        sigma_m: its standard deviations (right, forward, up).
    """

    direction: tuple[float, float, float]
    clearance_m: float
    sigma_m: tuple[float, float, float]


def _beside(right: float, forward: float) -> Sense:
    """Hand-sized things are put some centimetres apart; the hand wants room between them."""
    sigma = (0.03 if right else 0.02, 0.03 if forward else 0.02, 0.01)
    return Sense(direction=(right, forward, 0.0), clearance_m=0.035, sigma_m=sigma)


_SAME_PLACE: Final = Sense(direction=(0.0, 0.0, 0.0), clearance_m=0.0, sigma_m=(0.03, 0.03, 0.02))
SENSES: Final[dict[str, Sense]] = {
    "left-of": _beside(-1.0, 0.0),
    "right-of": _beside(1.0, 0.0),
    "in-front-of": _beside(0.0, -1.0),
    "behind": _beside(0.0, 1.0),
    "on-top-of": Sense(direction=(0.0, 0.0, 1.0), clearance_m=0.0, sigma_m=(0.01, 0.01, 0.005)),
    "under": Sense(direction=(0.0, 0.0, -1.0), clearance_m=0.0, sigma_m=(0.02, 0.02, 0.01)),
    "in": _SAME_PLACE,
    "from": _SAME_PLACE,
    "between": _SAME_PLACE,
    "near": Sense(direction=(0.0, 0.0, 0.0), clearance_m=0.035, sigma_m=(0.06, 0.06, 0.01)),
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Body:
    """A thing as relations see it.

    Attributes:
        position_world: (3,) its centre.
        size_m: (3,) its extents.
    """

    position_world: FloatArray
    size_m: FloatArray

    @property
    def reach_m(self) -> FloatArray:
        """(3,) half its size; in level directions that of its longer side, since it may turn."""
        side = float(max(self.size_m[0], self.size_m[1])) / 2
        return np.array([side, side, float(self.size_m[2]) / 2])


def sense_of(relation: str) -> Sense:
    """Return the built-in meaning; a relation that is not known is somewhere near."""
    return SENSES.get(relation, SENSES["near"])


def touching_offset(relation: str, *, thing: Body, landmark: Body) -> FloatArray:
    """Return the offset (3,) of centres, wearer's axes, at which the two just touch.

    A thing beside its landmark stands on the same level, so its middle is higher if it is taller.
    """
    direction = np.array(sense_of(relation).direction)
    offset = direction * (thing.reach_m + landmark.reach_m)
    if not direction[2]:
        offset[2] = thing.reach_m[2] - landmark.reach_m[2]
    return np.asarray(offset)


def wearer_axes(heading_rad: float) -> FloatArray:
    """Return (3, 3): the rows are right, forward and up of the wearer, in world."""
    c, s = np.cos(heading_rad), np.sin(heading_rad)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Demonstrated:
    """A thing that was put in a relation to a landmark.

    Attributes:
        relation: its normal form.
        thing: as it was left.
        landmark: where it stood then.
        heading_rad: the wearer's heading.
        weight: how sure that is, 0 to 1.
    """

    relation: str
    thing: Body
    landmark: Body
    heading_rad: float = 0.0
    weight: float = 1.0

    @property
    def free_m(self) -> FloatArray:
        """(3,) the offset beyond touching, in the wearer's axes."""
        off = self.thing.position_world - self.landmark.position_world
        touching = touching_offset(self.relation, thing=self.thing, landmark=self.landmark)
        return np.asarray(wearer_axes(self.heading_rad) @ off - touching)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LearntRelation:
    """A relation's free space as a normal distribution.

    Attributes:
        mean_m: (3,) wearer's axes.
        cov_m2: (3, 3) of one more instance, what is not known of the mean included.
        count: demonstrations it rests on; 0 is the built-in prior.
    """

    mean_m: FloatArray
    cov_m2: FloatArray
    count: float

    @property
    def is_prior(self) -> bool:
        """Whether nothing was seen of it."""
        return self.count == 0


def learn_relation(relation: str, seen: Sequence[Demonstrated]) -> LearntRelation:
    """Return a relation after some demonstrations, by a normal-inverse-Wishart update.

    The prior counts as one demonstration for the mean and as four for the covariance.

    Source:
        Murphy 2007, Conjugate Bayesian analysis of the Gaussian distribution, eq. 250 to 254.
    """
    sense = sense_of(relation)
    mean = np.array(sense.direction) * sense.clearance_m
    cov = np.diag(np.square(sense.sigma_m))
    mine = [each for each in seen if each.relation == relation and each.weight > 0]
    if not mine:
        return LearntRelation(mean_m=mean, cov_m2=cov, count=0.0)
    w = np.array([each.weight for each in mine])
    free = np.array([each.free_m for each in mine])  # (N, 3)
    count = float(w.sum())
    average = w @ free / count
    scatter = (free - average).T @ ((free - average) * w[:, None])
    apart = average - mean
    pull = count / (count + _MEAN_PRIOR)
    spread = _COV_PRIOR * cov + scatter + _MEAN_PRIOR * pull * np.outer(apart, apart)
    spread = spread / (_COV_PRIOR + count) * (1 + 1 / (_MEAN_PRIOR + count))
    return LearntRelation(mean_m=mean + pull * apart, cov_m2=spread, count=count)


def clearance_m(relation: str, seen: Sequence[Demonstrated]) -> float:
    """Return the free space to leave where a relation names no side, as learnt.

    The built-in clearance counts as one demonstration; things that touch or stand on each other
    have none.
    """
    free = [
        max(float(np.linalg.norm(off[:2]) - each.thing.reach_m[0] - each.landmark.reach_m[0]), 0.0)
        for each in seen
        if each.relation == relation
        for off in [each.thing.position_world - each.landmark.position_world]
    ]
    weight = [each.weight for each in seen if each.relation == relation]
    prior = _MEAN_PRIOR * sense_of(relation).clearance_m
    return float((prior + np.dot(weight, free)) / (_MEAN_PRIOR + sum(weight)))


_MEAN_PRIOR: Final = 1.0
_COV_PRIOR: Final = 4.0


def goal_of(
    learnt: LearntRelation,
    relation: str,
    *,
    thing: Body,
    landmarks: Sequence[Body],
    heading_rad: float = 0.0,
) -> tuple[FloatArray, FloatArray]:
    """Return where a thing's centre goes (3,) and its covariance (3, 3), in world.

    Args:
        learnt: the relation.
        relation: its normal form.
        thing: what is put; only its size counts.
        landmarks: one, or two for "between", of which the middle is taken.
        heading_rad: the wearer's heading.
    """
    landmark = Body(
        position_world=np.mean([each.position_world for each in landmarks], axis=0),
        size_m=np.mean([each.size_m for each in landmarks], axis=0),
    )
    axes = wearer_axes(heading_rad)
    offset = touching_offset(relation, thing=thing, landmark=landmark) + learnt.mean_m
    goal: FloatArray = landmark.position_world + axes.T @ offset
    cov: FloatArray = axes.T @ learnt.cov_m2 @ axes
    return goal, cov
