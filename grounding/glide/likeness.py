"""How alike the things are that an explanation calls by one word, eq. 26.

A word says something of how a thing looks, whatever it says: things that share one are alike in
colour or in size. Which words those are is not known, and any word will do.
"""

from collections.abc import Callable, Sequence
from itertools import combinations
from typing import Final

import numpy as np

from grounding.glide.read import Candidate, InstructionBelief
from grounding.places import parse_location
from grounding.types import ObjectInstance, SpokenInstruction

_LIKELY: Final = 0.5  # least probability of a thing that is taken to be called so
_COLOUR_SIGMA: Final = 12.0  # of two things of one colour, CIELAB
_SIZE_SIGMA: Final = 0.12  # of two things of one shape, logarithm of their sides
_BY_CHANCE: Final = 1 / 3  # share of all pairs that are alike without a word in common
_MISSED: Final = 0.05  # of two things that share a word and are not alike


def log_likeness(
    spoken: Sequence[SpokenInstruction],
    beliefs: Sequence[InstructionBelief],
    objects: Sequence[ObjectInstance],
) -> float:
    """Return the log of how much likelier the things look as they do if they are called so.

    Args:
        spoken: the instructions, in the order of the beliefs.
        beliefs: what each is taken to be about.
        objects: the instances.
    """
    by_id = {each.object_id: each for each in objects}
    called: dict[str, dict[str, ObjectInstance]] = {}
    for each, belief in zip(spoken, beliefs, strict=True):
        best = belief.candidates[0] if belief.candidates else None
        landmarks = parse_location(each.instruction.location).landmarks
        phrases = [(each.instruction.target, best)]
        phrases += [(phrase, belief.landmark) for phrase in landmarks if len(landmarks) == 1]
        for phrase, found in phrases:
            thing = _thing(found, by_id)
            if thing is not None:
                for word in phrase:
                    called.setdefault(word, {})[thing.object_id] = thing
    return sum(_log_of_word(list(things.values())) for things in called.values())


def _thing(found: Candidate | None, by_id: dict[str, ObjectInstance]) -> ObjectInstance | None:
    if found is None or found.object_id is None or found.probability < _LIKELY:
        return None
    return by_id.get(found.object_id)


def _log_of_word(things: Sequence[ObjectInstance]) -> float:
    """Return the log of a word's evidence: it may be one of colour or one of shape."""
    if len(things) < 2:
        return 0.0
    of_colour, of_shape = _log_alike(things, _colours_differ), _log_alike(things, _sizes_differ)
    return float(np.logaddexp(of_colour, of_shape) - np.log(2))


def _log_alike(
    things: Sequence[ObjectInstance], differ: Callable[[ObjectInstance, ObjectInstance], float]
) -> float:
    """Return the log over all pairs, which weigh as much as things beyond the first."""
    z = np.array([differ(one, other) for one, other in combinations(things, 2)])
    alike = (1 - _MISSED) * np.exp(-0.5 * z * z) / _BY_CHANCE + _MISSED
    return float((len(things) - 1) * np.log(alike).mean())


def _colours_differ(one: ObjectInstance, other: ObjectInstance) -> float:
    """Return by how many standard deviations; where a colour is not known it tells nothing."""
    if one.colour_lab is None or other.colour_lab is None:
        return float(np.sqrt(-2 * np.log(_BY_CHANCE)))
    return float(np.linalg.norm(one.colour_lab - other.colour_lab)) / _COLOUR_SIGMA


def _sizes_differ(one: ObjectInstance, other: ObjectInstance) -> float:
    sides = np.log(np.sort(one.size_m) / np.sort(other.size_m))
    return float(np.abs(sides).max()) / _SIZE_SIGMA
