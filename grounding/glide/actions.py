"""The plan P as a chain of elementary actions: taking, putting, and acting where a thing stands."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

from grounding.places import parse_location
from grounding.types import Action, Instruction, SpokenInstruction


class Kind(IntEnum):
    """What the eyes have to do in an action."""

    TAKE = 0  # the thing leaves its place
    PUT = 1  # the thing in hand comes to its place
    AT = 2  # the thing stays


@dataclass(frozen=True, slots=True, kw_only=True)
class Act:
    """One action A_i of the plan.

    Attributes:
        instruction: position of its instruction in the session's sequence.
        kind: what happens to the thing.
        in_hand: whether it goes on with the thing of the action before.
        name: the words that name the thing.
        landmarks: the words of the things its location refers to.
        relation: the relation to them, or None.
    """

    instruction: int
    kind: Kind
    in_hand: bool
    name: tuple[str, ...]
    landmarks: tuple[tuple[str, ...], ...] = ()
    relation: str | None = None


_CARRYING: Final = frozenset({Action.PLACE, Action.MOVE, Action.PUSH, Action.PULL})
_TAKING: Final = frozenset({Action.PICK, Action.GIVE})


def elementary_actions(spoken: Sequence[SpokenInstruction]) -> list[Act]:
    """Split a plan into elementary actions.

    "Put the cube on the box" is two actions, taking and putting, unless the cube is in hand
    already because the instruction before took it.

    Args:
        spoken: the instructions in the order said.

    Returns:
        The chain A_1..A_N; each instruction has one or two of them.
    """
    acts: list[Act] = []
    held: tuple[str, ...] | None = None
    for i, each in enumerate(spoken):
        instruction = each.instruction
        if instruction.action in _TAKING:
            acts.append(_act(i, Kind.TAKE, instruction))
            held = instruction.target
        elif instruction.action in _CARRYING and not _stays(instruction):
            in_hand = held is not None and _same_thing(held, instruction)
            if not in_hand:
                acts.append(_act(i, Kind.TAKE, instruction))
            acts.append(_act(i, Kind.PUT, instruction))
            held = None
        else:
            acts.append(_act(i, Kind.AT, instruction))
            held = held if instruction.action not in _CARRYING else None
    return acts


def whole_episodes(spoken: Sequence[SpokenInstruction], count: int) -> int:
    """Return the most instructions, up to a count, after which nothing is left in hand."""
    goes_on = {act.instruction: act.in_hand for act in reversed(elementary_actions(spoken))}
    while 0 < count < len(spoken) and goes_on[count]:
        count -= 1
    return count


def _stays(instruction: Instruction) -> bool:
    """Pushing or pulling at something, with no place said: it may not move at all."""
    return instruction.action in {Action.PUSH, Action.PULL} and instruction.has_own_location


def _same_thing(held: tuple[str, ...], instruction: Instruction) -> bool:
    return held == instruction.target or (
        instruction.resolved_from is not None and set(held) >= set(instruction.target)
    )


def _act(index: int, kind: Kind, instruction: Instruction) -> Act:
    place = parse_location(instruction.location)
    in_hand = kind is Kind.PUT
    if kind is not Kind.PUT or place.relation is None:
        return Act(instruction=index, kind=kind, in_hand=in_hand, name=instruction.target)
    return Act(
        instruction=index,
        kind=kind,
        in_hand=in_hand,
        name=instruction.target,
        landmarks=place.landmarks,
        relation=place.relation,
    )
