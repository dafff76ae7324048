"""A sentence against the present scene: what it means now, without a demonstration."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from grounding.glide.read import Candidate, InstructionBelief, Spot
from grounding.plan import GroundedInstruction, Status
from grounding.relations import (
    Body,
    Demonstrated,
    Place,
    goal_of,
    learn_relation,
    parse_location,
    sense_of,
)
from grounding.types import Action, ObjectInstance, SpokenInstruction

_SURE = 0.9
_FITS = 0.5  # a thing whose words hold together with less than this is not meant
_LANDMARK_SURE = 0.8
_PUTTING = frozenset({Action.PLACE, Action.MOVE, Action.PUSH, Action.PULL})


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class NamedThing:
    """A thing of the present scene and what it may be called.

    Attributes:
        instance: where it stands is the last of its resting places.
        words: for each word, how probable it is that the word holds; a word that is not there
            does not hold.
    """

    instance: ObjectInstance
    words: Mapping[str, float]

    def fits(self, phrase: Sequence[str]) -> float:
        """Return the probability that all words of a phrase hold."""
        return float(np.prod([self.words.get(word, 0.0) for word in phrase]))

    @property
    def body(self) -> Body:
        """The thing as relations see it."""
        return Body(
            position_world=self.instance.track[-1].position_world, size_m=self.instance.size_m
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PresentScene:
    """What a sentence is grounded in.

    Attributes:
        things: on the table now.
        known_words: all words that were learnt.
        seen: demonstrations of relations.
        heading_rad: the wearer's heading.
    """

    things: Sequence[NamedThing]
    known_words: frozenset[str]
    seen: Sequence[Demonstrated] = ()
    heading_rad: float = 0.0


def ground_sentence(spoken: SpokenInstruction, scene: PresentScene) -> GroundedInstruction:
    """Ground an instruction in the present scene, or say what has to be asked.

    Args:
        spoken: the instruction; its times play no part.
        scene: the things and what is known of words and relations.

    Returns:
        The grounded instruction; the reason says so where only a built-in relation was used.
    """
    instruction = spoken.instruction
    place = parse_location(instruction.location)
    said = [word for phrase in (instruction.target, *place.landmarks) for word in phrase]
    if unknown := [word for word in said if word not in scene.known_words]:
        return _unknown(spoken, unknown)
    targets = _described(_candidates(instruction.target, scene), spoken, scene)
    if not targets or targets[0].probability < _SURE:
        return _unsure(spoken, targets, what=instruction.target)
    target = targets[0]
    if instruction.action not in _PUTTING or place.relation is None:
        return _answer(spoken, target, target.spot, reason=None)
    landmarks = [_landmark(phrase, target, scene) for phrase in place.landmarks]
    for phrase, found in zip(place.landmarks, landmarks, strict=True):
        if not found or found[0].probability < _LANDMARK_SURE:
            return _unsure(spoken, found, what=phrase)
    return _put(spoken, target, [found[0] for found in landmarks], scene, place)


def demonstrations_of(
    spoken: Sequence[SpokenInstruction],
    beliefs: Sequence[InstructionBelief],
    *,
    heading_rad: float = 0.0,
) -> tuple[Demonstrated, ...]:
    """Return what a session showed of relations: each thing put beside a landmark."""
    shown = []
    for each, belief in zip(spoken, beliefs, strict=True):
        relation = parse_location(each.instruction.location).relation
        thing = belief.candidates[0] if belief.candidates else None
        landmark, goal = belief.landmark, belief.location
        if relation is None or thing is None or landmark is None or goal is None:
            continue
        if thing.size_m is None or landmark.size_m is None:
            continue
        weight = belief.done * goal.probability * landmark.probability
        if weight < _FITS:
            continue
        shown.append(
            Demonstrated(
                relation=relation,
                thing=Body(position_world=goal.position_world, size_m=thing.size_m),
                landmark=Body(position_world=landmark.spot.position_world, size_m=landmark.size_m),
                heading_rad=heading_rad,
                weight=weight,
            )
        )
    return tuple(shown)


def _candidates(phrase: Sequence[str], scene: PresentScene) -> list[Candidate]:
    """Return the things that fit a phrase, likeliest first; the probabilities sum to one."""
    fits = np.array([thing.fits(phrase) for thing in scene.things])
    total = max(float(fits.sum()), 1e-12)
    found = [
        _as_candidate(thing, float(fit / total))
        for thing, fit in zip(scene.things, fits, strict=True)
        if fit >= _FITS * fits.max(initial=0.0) and fits.max(initial=0.0) >= _FITS**2
    ]
    return sorted(found, key=lambda each: -each.probability)


def _as_candidate(thing: NamedThing, probability: float) -> Candidate:
    place = thing.instance.track[-1]
    return Candidate(
        object_id=thing.instance.object_id,
        spot=Spot(
            position_world=place.position_world,
            cov_world=place.cov_world,
            probability=probability,
        ),
        quat_xyzw=place.quat_xyzw,
        size_m=thing.instance.size_m,
    )


def _reweighted(found: Sequence[Candidate], factors: Sequence[float]) -> list[Candidate]:
    weights = np.array([c.probability for c in found]) * np.asarray(factors)
    if not weights.sum():
        return list(found)
    weights /= weights.sum()
    again = [
        Candidate(
            object_id=c.object_id,
            spot=Spot(
                position_world=c.spot.position_world,
                cov_world=c.spot.cov_world,
                probability=float(w),
            ),
            quat_xyzw=c.quat_xyzw,
            size_m=c.size_m,
        )
        for c, w in zip(found, weights, strict=True)
    ]
    return sorted(again, key=lambda each: -each.probability)


def _described(
    found: Sequence[Candidate], spoken: SpokenInstruction, scene: PresentScene
) -> list[Candidate]:
    """Weigh the candidates by a phrase that describes the target ("on the left of the box")."""
    described = spoken.instruction.target_relation
    place = parse_location(described) if described else None
    if place is None or place.relation is None or len(found) < 2:
        return list(found)
    landmarks = [c for phrase in place.landmarks for c in _candidates(phrase, scene)[:1]]
    if not landmarks:
        return list(found)
    learnt = learn_relation(place.relation, scene.seen)
    factors = []
    for each in found:
        goal, cov = goal_of(
            learnt,
            place.relation,
            thing=_body(each),
            landmarks=[_body(c) for c in landmarks],
            heading_rad=scene.heading_rad,
        )
        off = (each.spot.position_world - goal)[:2]
        spread = 9.0 * cov[:2, :2]  # described loosely, not put there
        factors.append(float(np.exp(-0.5 * off @ np.linalg.solve(spread, off))) + 1e-9)
    return _reweighted(found, factors)


def _body(candidate: Candidate) -> Body:
    size = candidate.size_m if candidate.size_m is not None else np.full(3, 0.04)
    return Body(position_world=candidate.spot.position_world, size_m=size)


def _landmark(phrase: Sequence[str], target: Candidate, scene: PresentScene) -> list[Candidate]:
    """Return what a landmark may be; a thing is not put beside itself."""
    found = [c for c in _candidates(phrase, scene) if c.object_id != target.object_id]
    return _reweighted(found, [1.0] * len(found)) if found else []


def _put(
    spoken: SpokenInstruction,
    target: Candidate,
    landmarks: Sequence[Candidate],
    scene: PresentScene,
    place: Place,
) -> GroundedInstruction:
    relation = place.relation or "near"
    learnt = learn_relation(relation, scene.seen)
    goal, cov = goal_of(
        learnt,
        relation,
        thing=_body(target),
        landmarks=[_body(c) for c in landmarks],
        heading_rad=scene.heading_rad,
    )
    if relation == "near":
        goal = _free_side(goal, target, landmarks[0], scene)
    cov = cov + np.mean([c.spot.cov_world for c in landmarks], axis=0)
    sure = min(c.probability for c in landmarks)
    spot = Spot(position_world=goal, cov_world=cov, probability=sure)
    reason = f"no demonstration of '{relation}': the built-in meaning" if learnt.is_prior else None
    return _answer(spoken, target, spot, reason=reason)


def _free_side(
    goal: np.ndarray, target: Candidate, landmark: Candidate, scene: PresentScene
) -> np.ndarray:
    """Return the place beside a landmark that is farthest from everything else."""
    apart = float(_body(target).reach_m[0] + _body(landmark).reach_m[0])
    apart += sense_of("near").clearance_m
    angles = np.arange(8) * np.pi / 4
    around = goal + apart * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    others = [
        thing.body.position_world
        for thing in scene.things
        if thing.instance.object_id not in {target.object_id, landmark.object_id}
    ]
    if not others:
        return np.asarray(around[0])
    off = np.linalg.norm(around[:, None, :2] - np.array(others)[None, :, :2], axis=2)
    return np.asarray(around[int(off.min(axis=1).argmax())])


def _answer(
    spoken: SpokenInstruction, target: Candidate, location: Spot, *, reason: str | None
) -> GroundedInstruction:
    return GroundedInstruction(
        spoken=spoken,
        start_ns=None,
        end_ns=None,
        status=Status.GROUNDED,
        confidence=min(target.probability, location.probability),
        target=target,
        location=location,
        reason=reason,
    )


def _unknown(spoken: SpokenInstruction, words: Sequence[str]) -> GroundedInstruction:
    word = words[0]
    return GroundedInstruction(
        spoken=spoken,
        start_ns=None,
        end_ns=None,
        status=Status.UNKNOWN_SYMBOL,
        confidence=0.0,
        target=None,
        location=None,
        question=f"What does '{word}' mean? Please show me one.",
        reason=f"unknown: {', '.join(dict.fromkeys(words))}",
    )


def _unsure(
    spoken: SpokenInstruction, found: Sequence[Candidate], *, what: Sequence[str]
) -> GroundedInstruction:
    phrase = " ".join(what)
    return GroundedInstruction(
        spoken=spoken,
        start_ns=None,
        end_ns=None,
        status=Status.AMBIGUOUS if found else Status.UNGROUNDED,
        confidence=found[0].probability if found else 0.0,
        target=None,
        location=None,
        candidates=tuple(found),
        question=f"Which one is the {phrase}?" if found else None,
        reason=f"several things may be the {phrase}" if found else f"nothing here is a {phrase}",
    )
