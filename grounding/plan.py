"""The grounded plan: what each instruction means in the world, and how sure that is."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from grounding.glide.align import Alignment
from grounding.glide.read import Candidate, InstructionBelief, Spot
from grounding.types import FloatArray, SpokenInstruction


class Status(StrEnum):
    """How far an instruction is grounded."""

    GROUNDED = "grounded"
    AMBIGUOUS = "ambiguous"
    UNKNOWN_SYMBOL = "unknown-symbol"
    UNGROUNDED = "ungrounded"


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanConfig:
    """When a belief counts as sure.

    Attributes:
        sure: least probability of a target or location that is called grounded.
        done: least probability that an instruction was done at all.
        over: least probability that an action is over, while the session goes on.
        sigma_m: largest horizontal standard deviation of a position a gripper can use, in the units
            of the world.
        looks: least expected number of looks that speak for it.
        looks_unseen: the same where vision has no instance of the target.
        fit: least share of the looks within actions that are at what they should be at.
        fit_of_few: the same while a session goes on or where little was said: a share of few looks
            is uncertain, and a plan must not come and go with single looks.
        beyond_chance: least evidence beyond that of looks in disorder, standard deviations.
        told_by_chance: least number of instructions for which that says anything.
        candidate: least probability of a candidate that is named.
        kept: share of `sure`, `done`, `over`, `looks` and `fit_of_few` that suffices, while a
            session goes on, for what was grounded already and is still about the same thing. Each
            new look moves a posterior a little; what is published must not come and go with them,
            and be taken back only where the evidence has turned.
    """

    sure: float = 0.95
    done: float = 0.8
    over: float = 0.9
    sigma_m: float = 0.02
    looks: float = 0.9
    looks_unseen: float = 1.8
    fit: float = 0.65
    fit_of_few: float = 0.55
    beyond_chance: float = 5.0
    told_by_chance: int = 6
    candidate: float = 0.02
    kept: float = 0.8

    @property
    def for_kept(self) -> "PlanConfig":
        """When a belief that counted as sure counts as sure still."""
        return dataclasses.replace(
            self,
            sure=self.kept * self.sure,
            done=self.kept * self.done,
            over=self.kept * self.over,
            looks=self.kept * self.looks,
            looks_unseen=self.kept * self.looks_unseen,
            fit_of_few=self.kept * self.fit_of_few,
            sigma_m=self.sigma_m / self.kept,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Unparsed:
    """A sentence without an instruction."""

    sentence: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GroundedInstruction:
    """One instruction of the plan; `plan.json` has its fields, in SI units and world.

    Attributes:
        spoken: what was said.
        start_ns: start of the action, or None.
        end_ns: its end, or None.
        status: how far it is grounded.
        confidence: posterior probability of what is given.
        target: where the target stood and what it is, or None where that is not sure.
        location: where the action leaves it, or None where that is not sure.
        fixations: ids of the fixations that belong to it.
        patches: names of the patches labelled with its target.
        candidates: what the target may be, where it is not sure.
        question: what to ask the human, or None.
        reason: why it is not grounded, or None.
    """

    spoken: SpokenInstruction
    start_ns: int | None
    end_ns: int | None
    status: Status
    confidence: float
    target: Candidate | None
    location: Spot | None
    fixations: tuple[int, ...] = ()
    patches: tuple[str, ...] = ()
    candidates: tuple[Candidate, ...] = ()
    question: str | None = None
    reason: str | None = None

    def to_json(self) -> dict[str, object]:
        """Return the instruction as INTERFACES.md, 5, has it."""
        instruction, target, location = self.spoken.instruction, self.target, self.location
        return {
            "index": self.spoken.index,
            "sentence": self.spoken.sentence,
            "action": str(instruction.action),
            "target": list(instruction.target),
            "location": instruction.location,
            "start_ns": self.start_ns,
            "end_ns": self.end_ns,
            "status": str(self.status),
            "confidence": round(self.confidence, 6),
            "object": target.object_id if target else None,
            "target_position": _numbers(target.spot.position_world if target else None),
            "target_orientation": _numbers(target.quat_xyzw if target else None),
            "target_size": _numbers(target.size_m if target else None),
            "target_covariance": _numbers(target.spot.cov_world if target else None),
            "location_position": _numbers(location.position_world if location else None),
            "location_covariance": _numbers(location.cov_world if location else None),
            "fixations": list(self.fixations),
            "patches": list(self.patches),
            "candidates": [_candidate_json(c) for c in self.candidates],
            "question": self.question,
            "reason": self.reason,
        }


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GroundedPlan:
    """The plan of a session.

    Attributes:
        session: its name.
        revision: grows with each correction.
        scale: "metric" or "arbitrary".
        instructions: in the order said.
        unparsed: sentences that gave none.
    """

    session: str
    revision: int
    scale: str
    instructions: tuple[GroundedInstruction, ...]
    unparsed: tuple[Unparsed, ...] = ()

    @property
    def symbols(self) -> tuple[str, ...]:
        """The paper's symbol set S: every symbol of any target, in the order said."""
        words = (w for each in self.instructions for w in each.spoken.instruction.target)
        return tuple(dict.fromkeys(words))

    @property
    def has_grounded(self) -> bool:
        """Whether any instruction is grounded."""
        return any(each.status is Status.GROUNDED for each in self.instructions)

    def to_json(self) -> dict[str, object]:
        """Return the content of `plan.json`."""
        return {
            "session": self.session,
            "revision": self.revision,
            "frame": "world",
            "scale": self.scale,
            "symbols": list(self.symbols),
            "unparsed": [{"sentence": u.sentence, "reason": u.reason} for u in self.unparsed],
            "instructions": [each.to_json() for each in self.instructions],
        }

    def revised(self, instructions: Sequence[GroundedInstruction]) -> "GroundedPlan":
        """Return the plan with these instructions, one revision on."""
        return dataclasses.replace(
            self, revision=self.revision + 1, instructions=tuple(instructions)
        )


def ground_instructions(
    spoken: Sequence[SpokenInstruction],
    alignment: Alignment,
    config: PlanConfig,
    *,
    open_end: bool = False,
    is_believed: bool = True,
    before: GroundedPlan | None = None,
) -> tuple[GroundedInstruction, ...]:
    """Decide for each instruction what is sure; what is not sure is left open.

    Args:
        spoken: the instructions.
        alignment: what the looks say of them.
        config: when a belief counts as sure.
        open_end: the session goes on; what is put somewhere is settled when that is over.
        is_believed: whether gaze and narration go together at all.
        before: the plan of a moment ago, while the session goes on.
    """
    found = []
    for each, belief in zip(spoken, alignment.instructions, strict=True):
        is_kept = _is_kept(each, belief, before)
        limits = config.for_kept if is_kept else config
        is_open = open_end and belief.moves and belief.over < limits.over
        seen = dataclasses.replace(belief, location=None) if is_open else belief
        found.append(_ground(each, seen, limits))
    return tuple(x if is_believed else _doubted(x, alignment) for x in found)


def _is_kept(
    spoken: SpokenInstruction, belief: InstructionBelief, before: GroundedPlan | None
) -> bool:
    """Return whether an instruction was grounded already, in what is still likeliest."""
    if before is None or spoken.index >= len(before.instructions) or not belief.candidates:
        return False
    then, best = before.instructions[spoken.index], belief.candidates[0]
    if then.status is not Status.GROUNDED or then.target is None or then.spoken != spoken:
        return False
    return then.target.object_id == best.object_id


def _doubted(each: GroundedInstruction, alignment: Alignment) -> GroundedInstruction:
    """Take back what a gaze that does not go with the narration seems to say."""
    if each.status is Status.UNGROUNDED:
        return each
    return dataclasses.replace(
        each,
        status=Status.UNGROUNDED,
        confidence=each.confidence * alignment.fit,
        target=None,
        location=None,
        fixations=(),
        question=None,
        candidates=each.candidates or ((each.target,) if each.target else ()),
        reason=f"gaze and narration do not go together: {alignment.fit:.0%} of the looks fit",
    )


def _ground(
    spoken: SpokenInstruction, belief: InstructionBelief, config: PlanConfig
) -> GroundedInstruction:
    best = belief.candidates[0] if belief.candidates else None
    place = belief.location
    if place is None and not belief.moves and best is not None:
        place = best.spot
    target = best if best is not None and _is_sure(best.spot, config) else None
    location = place if place is not None and _is_sure(place, config) else None
    status, reason = _status(belief, target, location, config)
    shares = [spot.probability if spot else 0.0 for spot in (best, place)]
    open_ones = tuple(c for c in belief.candidates if c.probability >= config.candidate)
    return GroundedInstruction(
        spoken=spoken,
        start_ns=belief.start_ns,
        end_ns=belief.end_ns,
        status=status,
        confidence=float(np.clip(belief.done * min(shares), 0.0, 1.0)),
        target=target if status is not Status.UNGROUNDED else None,
        location=location if status is not Status.UNGROUNDED else None,
        fixations=belief.fixation_ids,
        candidates=() if status is Status.GROUNDED else open_ones,
        question=_question(spoken, status),
        reason=reason,
    )


def _is_sure(spot: Spot, config: PlanConfig) -> bool:
    spread = float(np.sqrt(np.linalg.eigvalsh(spot.cov_world[:2, :2])[-1]))
    return spot.probability >= config.sure and spread <= config.sigma_m


def _status(
    belief: InstructionBelief,
    target: Candidate | None,
    location: Spot | None,
    config: PlanConfig,
) -> tuple[Status, str | None]:
    if target is not None and location is not None and _was_done(belief, config):
        return Status.GROUNDED, None
    likely = [c for c in belief.candidates if c.probability >= config.candidate]
    if belief.start_ns is None or belief.done < 0.5:
        reason = "no look fits this instruction; it may not have been done"
    elif not _is_seen(belief, config):
        reason = "too few looks at anything it may mean"
    elif target is None and len(likely) > 1:
        return Status.AMBIGUOUS, "several things fit"
    elif target is None or location is None:
        reason = f"the {'location' if target else 'target'}'s position is not certain enough"
    else:
        reason = "it is not certain that it was done"
    return Status.UNGROUNDED, reason


def _was_done(belief: InstructionBelief, config: PlanConfig) -> bool:
    return belief.start_ns is not None and _is_seen(belief, config) and belief.done >= config.done


def _is_seen(belief: InstructionBelief, config: PlanConfig) -> bool:
    has_instance = bool(belief.candidates) and belief.candidates[0].object_id is not None
    return belief.looks >= (config.looks if has_instance else config.looks_unseen)


def _question(spoken: SpokenInstruction, status: Status) -> str | None:
    if status is not Status.AMBIGUOUS:
        return None
    return f"Which one is the {' '.join(spoken.instruction.target)}?"


def _candidate_json(candidate: Candidate) -> dict[str, object]:
    return {
        "object": candidate.object_id,
        "position": _numbers(candidate.spot.position_world),
        "orientation": _numbers(candidate.quat_xyzw),
        "size": _numbers(candidate.size_m),
        "probability": round(candidate.probability, 6),
    }


def _numbers(array: FloatArray | None) -> object:
    return None if array is None else np.asarray(array, dtype=np.float64).tolist()
