"""Other explanations of a session that one pass of the model does not reach, eq. 25.

The model goes from left to right, so instructions that were done in another order than said are
another plan; and where vision saw more movements than were spoken of, learning settles on one of
several ways to match them. Such explanations are tried one change at a time, again from the best
one found, until none is better. What is said of an instruction is then averaged over them by their
posterior: what they disagree about shows as doubt.
"""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, TypeVar

import numpy as np

from grounding.glide.actions import Kind, elementary_actions
from grounding.glide.align import Alignment
from grounding.glide.likeness import log_likeness
from grounding.glide.model import Demonstration
from grounding.glide.read import Candidate, InstructionBelief, Spot
from grounding.types import SpokenInstruction

_NEGLIGIBLE: Final = 1e-3  # posterior of an explanation that is left out of the average
_STEPS: Final = 4  # most changes that are followed
_UNSAID_TRIED: Final = 3  # movements tried for each thing that was spoken of

V = TypeVar("V")
Order = tuple[int, ...]  # positions in the sequence as said, in the order done
Align = Callable[[Demonstration], Alignment]


@dataclass(frozen=True, slots=True, kw_only=True)
class Mode:
    """An explanation: in which order things were done, and what some of them must be about.

    Attributes:
        order: positions in the sequence as said, in the order done.
        about: positions as said and the object that each is about.
    """

    order: Order
    about: tuple[tuple[int, str], ...] = ()


def align_all_modes(
    demonstration: Demonstration, align: Align, *, prior: float, as_said: Alignment
) -> Alignment:
    """Return the best explanation's alignment, its beliefs averaged with those beside it.

    Args:
        demonstration: the session.
        align: infers one explanation.
        prior: probability that two given neighbours were done the other way round.
        as_said: the alignment in the order said.

    Returns:
        An alignment with its instructions in the order said.
    """
    best = Mode(order=tuple(range(len(demonstration.spoken))))
    found, scores = {best: as_said}, {best: _score(demonstration, as_said, best, prior)}
    for _ in range(_STEPS):
        for mode in _neighbours(best, found[best], demonstration):
            if mode not in found:
                found[mode] = _as_said(align(_under(demonstration, mode)), mode.order)
                scores[mode] = _score(demonstration, found[mode], mode, prior)
        better = max(scores, key=lambda mode: scores[mode])
        if better == best:
            break
        best = better
    different = _different(found, scores)
    weights = np.exp(np.array([scores[mode] for mode in different]) - scores[best])
    weights /= weights.sum()
    parts = [(found[m], w) for m, w in zip(different, weights.tolist(), strict=True)]
    return _averaged(found[best], [(each, w) for each, w in parts if w > _NEGLIGIBLE])


def _score(demonstration: Demonstration, alignment: Alignment, mode: Mode, prior: float) -> float:
    """Return the log posterior up to a constant, eq. 25: each change of order costs its prior."""
    changes = sum(1 for a, b in pairwise(mode.order) if b < a)
    alike = log_likeness(demonstration.spoken, alignment.instructions, demonstration.objects)
    return float(alignment.log_evidence + alike + changes * np.log(prior))


def _different(found: Mapping[Mode, Alignment], scores: Mapping[Mode, float]) -> list[Mode]:
    """Return one mode for each explanation: several ways may lead to the same."""
    best: dict[tuple[object, ...], Mode] = {}
    for mode in sorted(found, key=lambda m: -scores[m]):
        key = tuple(
            (each.candidates[0].object_id if each.candidates else None, each.end_ns)
            for each in found[mode].instructions
        )
        best.setdefault(key, mode)
    return list(best.values())


def _neighbours(mode: Mode, alignment: Alignment, demonstration: Demonstration) -> list[Mode]:
    """Return the explanations that are one change away."""
    return _other_orders(mode, demonstration) + _other_things(mode, alignment, demonstration)


def _episodes(order: Order, demonstration: Demonstration) -> list[Order]:
    """Return the order cut into runs on one thing in hand."""
    acts = elementary_actions([demonstration.spoken[i] for i in order])
    goes_on = {act.instruction: act.in_hand for act in reversed(acts)}
    episodes: list[list[int]] = []
    for k, i in enumerate(order):
        if goes_on[k] and episodes:
            episodes[-1].append(i)
        else:
            episodes.append([i])
    return [tuple(each) for each in episodes]


def _other_orders(mode: Mode, demonstration: Demonstration) -> list[Mode]:
    """Change two neighbouring episodes that differ."""
    episodes = _episodes(mode.order, demonstration)
    found = []
    for k, (here, there) in enumerate(pairwise(episodes)):
        if _content(here, demonstration) != _content(there, demonstration):
            changed = [*episodes[:k], there, here, *episodes[k + 2 :]]
            order = tuple(i for each in changed for i in each)
            found.append(dataclasses.replace(mode, order=order))
    return found


def _content(episode: Order, demonstration: Demonstration) -> list[tuple[object, ...]]:
    said = [demonstration.spoken[i].instruction for i in episode]
    return [(each.action, each.target, each.location) for each in said]


def _other_things(mode: Mode, alignment: Alignment, demonstration: Demonstration) -> list[Mode]:
    """Let each thing that was carried be one that moved about then and was not spoken of."""
    carried = {
        act.instruction for act in elementary_actions(demonstration.spoken) if act.kind is Kind.PUT
    }
    beliefs = alignment.instructions
    spoken_of = {beliefs[i].candidates[0].object_id for i in carried if beliefs[i].candidates}
    unsaid = [o for o in demonstration.objects if len(o.track) > 1 and o.object_id not in spoken_of]
    moves = sum(len(o.track) - 1 for o in demonstration.objects)
    if moves <= len(carried):
        return []
    found = []
    for episode in _episodes(mode.order, demonstration):
        first, start = episode[0], beliefs[episode[0]].start_ns or 0
        if not carried & set(episode) or first in demonstration.meant:
            continue
        near = sorted(unsaid, key=lambda o: abs((o.track[0].left_ns or 0) - start))
        kept = tuple(each for each in mode.about if each[0] != first)
        found += [
            dataclasses.replace(mode, about=(*kept, (first, thing.object_id)))
            for thing in near[:_UNSAID_TRIED]
        ]
    return found


def _under(demonstration: Demonstration, mode: Mode) -> Demonstration:
    """Return the session as if it had been said in the mode's order, at the same times."""
    said, order = demonstration.spoken, mode.order
    spoken: list[SpokenInstruction] = [
        dataclasses.replace(
            said[i], said_start_ns=said[k].said_start_ns, said_end_ns=said[k].said_end_ns
        )
        for k, i in enumerate(order)
    ]
    return dataclasses.replace(
        demonstration,
        spoken=spoken,
        meant=_moved({**demonstration.meant, **dict(mode.about)}, order),
        not_meant=_moved(demonstration.not_meant, order),
    )


def _moved(told: Mapping[int, V], order: Order) -> dict[int, V]:
    return {k: told[i] for k, i in enumerate(order) if i in told}


def _as_said(alignment: Alignment, order: Order) -> Alignment:
    """Return the alignment with its instructions in the order said."""
    back = np.argsort(order)
    instructions = tuple(alignment.instructions[k] for k in back)
    return dataclasses.replace(alignment, instructions=instructions)


def _averaged(best: Alignment, parts: Sequence[tuple[Alignment, float]]) -> Alignment:
    if len(parts) == 1:
        return best
    total = sum(w for _, w in parts)
    instructions = tuple(
        _belief(each, [(part.instructions[i], w / total) for part, w in parts])
        for i, each in enumerate(best.instructions)
    )
    agreeing = [
        sum(w for part, w in parts if part.looks[t].instruction == look.instruction) / total
        for t, look in enumerate(best.looks)
    ]
    looks = tuple(
        dataclasses.replace(look, probability=look.probability * agrees)
        for look, agrees in zip(best.looks, agreeing, strict=True)
    )
    return dataclasses.replace(best, instructions=instructions, looks=looks)


def _belief(
    best: InstructionBelief, parts: Sequence[tuple[InstructionBelief, float]]
) -> InstructionBelief:
    """Return the best mode's belief with its candidates and location weighed by all modes."""
    mixed: dict[tuple[object, ...], Candidate] = {}
    for belief, w in parts:
        for each in belief.candidates:
            key = (each.object_id, *each.spot.position_world.round(3).tolist())
            before = mixed[key].probability if key in mixed else 0.0
            spot = dataclasses.replace(each.spot, probability=before + w * each.probability)
            mixed[key] = dataclasses.replace(mixed.get(key, each), spot=spot)
    location = best.location
    if location is not None:
        share = sum(w * _same_place(belief.location, location) for belief, w in parts)
        location = dataclasses.replace(location, probability=share)
    return dataclasses.replace(
        best,
        candidates=tuple(sorted(mixed.values(), key=lambda c: -c.probability)),
        location=location,
    )


def _same_place(one: Spot | None, other: Spot) -> float:
    """Return the probability that a spot gives to the place of another."""
    if one is None:
        return 0.0
    sigma = float(np.sqrt(np.trace(other.cov_world[:2, :2]))) + 1e-3
    near = float(np.linalg.norm(one.position_world - other.position_world)) < 3 * sigma
    return one.probability if near else 0.0
