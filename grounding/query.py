"""A sentence against the present scene: what it means now, without a demonstration."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from grounding.glide.read import Candidate, InstructionBelief, Spot
from grounding.places import Place, parse_location
from grounding.plan import GroundedInstruction, Status
from grounding.relations import (
    SENSES,
    Body,
    Demonstrated,
    clearance_m,
    goal_of,
    learn_relation,
)
from grounding.types import Action, FloatArray, ObjectInstance, SpokenInstruction

_SURE = 0.9
_FITS = 0.5  # a thing whose words hold together with less than this is not meant
_LANDMARK_SURE = 0.8
_BOTH = 2  # things that another is put between
_SIDES = 16  # of a thing that another may stand near
_ROOM_M = 0.04  # between two things; more is no better
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
    targets = _described(_candidates(instruction.target, scene), instruction.target_relation, scene)
    if not targets or targets[0].probability < _SURE:
        return _unsure(spoken, targets, what=instruction.target)
    target = targets[0]
    if instruction.action not in _PUTTING or instruction.has_own_location:
        return _answer(spoken, target, target.spot, reason=None)
    if not _is_understood(place, scene):
        return _unknown_relation(spoken, place)
    return _put_beside(spoken, target, place, scene)


def _put_beside(
    spoken: SpokenInstruction, target: Candidate, place: Place, scene: PresentScene
) -> GroundedInstruction:
    """Ground a putting whose target is known: "between the cubes" are two of one name."""
    landmarks: list[Candidate] = []
    for phrase, described in zip(place.landmarks, place.described, strict=True):
        found = _described(_landmark(phrase, target, scene), described, scene)
        if place.relation == "between" and len(place.landmarks) == 1:
            if len(found) != _BOTH:
                return _unsure(spoken, found, what=phrase)
            landmarks = found
        elif not found or found[0].probability < _LANDMARK_SURE:
            return _unsure(spoken, found, what=phrase)
        else:
            landmarks.append(found[0])
    return _put(spoken, target, landmarks, scene, place)


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


def _is_understood(place: Place, scene: PresentScene) -> bool:
    """Return whether a relation has a built-in meaning or was shown."""
    return place.relation in SENSES or any(x.relation == place.relation for x in scene.seen)


def _described(
    found: Sequence[Candidate], described: str | None, scene: PresentScene
) -> list[Candidate]:
    """Weigh the candidates by a location that describes them ("the cube on the box")."""
    place = parse_location(described) if described else None
    if place is None or not _is_understood(place, scene) or len(found) < 2:
        return list(found)
    relation = place.relation or "near"
    landmarks = [c for phrase in place.landmarks for c in _candidates(phrase, scene)[:1]]
    if not landmarks:
        return list(found)
    learnt = learn_relation(relation, scene.seen)
    factors = []
    for each in found:
        goal, cov = goal_of(
            learnt,
            relation,
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
    sure = 1.0 if len(landmarks) > len(place.landmarks) else min(c.probability for c in landmarks)
    spot = Spot(position_world=goal, cov_world=cov, probability=sure)
    reason = f"no demonstration of '{relation}': the built-in meaning" if learnt.is_prior else None
    return _answer(spoken, target, spot, reason=reason)


def _free_side(
    goal: FloatArray, target: Candidate, landmark: Candidate, scene: PresentScene
) -> FloatArray:
    """Return the place beside a landmark that has room; of several the nearest to the thing.

    So it stays on the table: both it and the landmark stand there.
    """
    apart = float(_body(target).reach_m[0] + _body(landmark).reach_m[0])
    apart += clearance_m("near", scene.seen)
    angles = np.arange(_SIDES) * 2 * np.pi / _SIDES
    ring = apart * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    around = np.append(landmark.spot.position_world[:2], goal[2]) + ring  # (sides, 3)
    others = [
        thing.body
        for thing in scene.things
        if thing.instance.object_id not in {target.object_id, landmark.object_id}
    ]
    mine = float(_body(target).reach_m[0])
    off = np.array(
        [
            np.linalg.norm((around - each.position_world)[:, :2], axis=1) - each.reach_m[0] - mine
            for each in others
        ]
    ).reshape(len(others), _SIDES)
    room = np.minimum(off.min(axis=0, initial=_ROOM_M), _ROOM_M)
    far = np.linalg.norm((around - target.spot.position_world)[:, :2], axis=1)
    return np.asarray(around[int(np.lexsort((far, -np.round(room, 3)))[0])])


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
    reason = f"unknown: {', '.join(dict.fromkeys(words))}"
    question = f"What does '{words[0]}' mean? Please show me one."
    return _unanswered(spoken, Status.UNKNOWN_SYMBOL, question=question, reason=reason)


def _unknown_relation(spoken: SpokenInstruction, place: Place) -> GroundedInstruction:
    said = " ".join((place.relation or spoken.instruction.location).split("-"))
    return _unanswered(
        spoken,
        Status.UNKNOWN_SYMBOL,
        question=f"Where is '{said}'? Please show me.",
        reason=f"no demonstration of '{said}', and no built-in meaning",
    )


def _unsure(
    spoken: SpokenInstruction, found: Sequence[Candidate], *, what: Sequence[str]
) -> GroundedInstruction:
    phrase = " ".join(what)
    if not found:
        reason = f"nothing here is a {phrase}"
        return _unanswered(spoken, Status.UNGROUNDED, question=None, reason=reason)
    answer = _unanswered(
        spoken,
        Status.AMBIGUOUS,
        question=f"Which one is the {phrase}?",
        reason=f"several things may be the {phrase}",
    )
    return replace(answer, confidence=found[0].probability, candidates=tuple(found))


def _unanswered(
    spoken: SpokenInstruction, status: Status, *, question: str | None, reason: str
) -> GroundedInstruction:
    return GroundedInstruction(
        spoken=spoken,
        start_ns=None,
        end_ns=None,
        status=status,
        confidence=0.0,
        target=None,
        location=None,
        question=question,
        reason=reason,
    )
