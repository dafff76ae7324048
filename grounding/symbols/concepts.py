"""Concept groups: which words describe the same features, and so exclude each other.

A word describes a family of features (colour, size, shape) when things that bear it are more
alike in that family than they are to other things; how much more than chance is told by a
permutation test over whole segments. Words with like profiles that are never said together form
a group. A quarter of the labels may be wrong: distances saturate, so a stranger counts once.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from grounding.features.registry import Family
from grounding.symbols.compounds import head_of
from grounding.types import FloatArray

_PERMUTATIONS: Final = 200
_MAX_SEGMENTS: Final = 300
_SATURATION: Final = 3.0  # resolutions, root mean square over a family
_SIGNIFICANT: Final = 2.5  # standard deviations of the permuted statistic
_LIKELY: Final = 0.3
_SHARE_OF_BEST: Final = 0.3  # a weaker family is a side effect, unless no group describes it better
_SHARE_OF_RIVAL: Final = 0.6  # of words said together with them: else what those say shows through
_LIKE: Final = 0.4  # cosine of profiles
_SAID_TOGETHER: Final = 0.1  # of the rarer word's segments


@dataclass(frozen=True, slots=True, kw_only=True)
class Concept:
    """A group of words that exclude each other, and the families that they describe.

    Without families the words are too little known to say what they describe.

    Attributes:
        words: in alphabetical order.
        families: what they describe.
        kind_of: the head of the compounds that it holds; empty for plain words.
    """

    words: tuple[str, ...]
    families: tuple[Family, ...]
    kind_of: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SegmentTable:
    """One row a segment.

    Attributes:
        centres: (S, D) median features in resolutions.
        families: (D,) of each feature.
        bears: word -> (S,) whether the segment bears it.
    """

    centres: FloatArray
    families: tuple[Family, ...]
    bears: dict[str, NDArray[np.bool_]]


def find_concepts(table: SegmentTable, rng: np.random.Generator) -> list[Concept]:
    """Group words by what they describe.

    Args:
        table: the segments.
        rng: for the permutation tests.

    Returns:
        Groups in the order of their first word; words that fit no other are alone.
    """
    table = _thinned(table)
    families = tuple(dict.fromkeys(table.families))
    profiles = _profiles(table, families, rng)
    groups: list[list[str]] = []
    for word in sorted(profiles, key=lambda w: (-profiles[w].max(initial=0), w)):
        _join(word, groups, profiles, table)
    joint = [
        np.sum([profiles[word] for word in words], axis=0) / np.sqrt(len(words)) for words in groups
    ]
    best = np.max(joint, axis=0, initial=0)
    concepts = [
        Concept(
            words=tuple(sorted(words)),
            families=_told(profile, best, _rival(words, groups, joint, table), families),
        )
        for words, profile in zip(groups, joint, strict=True)
    ]
    concepts = _adopt(concepts, table)
    return sorted(concepts, key=lambda c: c.words)


def _rival(
    words: list[str], groups: list[list[str]], joint: list[FloatArray], table: SegmentTable
) -> FloatArray:
    """Return how surely (F,) the words describe each family that are said together with these."""
    together = [
        profile
        for others, profile in zip(groups, joint, strict=True)
        if others is not words
        and any(_are_said_together(table, one, other) for one in words for other in others)
    ]
    return np.max(together, axis=0) if together else np.zeros(len(joint[0]))


def _adopt(concepts: list[Concept], table: SegmentTable) -> list[Concept]:
    """Give each word that too few patches bear to the one group it is never said together with.

    "yellow", said of cells and cubes but never of red things, is a colour before it is seen often.
    """
    sure = {concept.words: concept for concept in concepts if concept.families}
    left = []
    for concept in concepts:
        if concept.families:
            continue
        fits = [
            words
            for words, known in sure.items()
            if not any(
                _exclude_a_group(table, one, other)
                for one in concept.words
                for other in known.words
            )
        ]
        if len(fits) == 1 < len(sure):
            grown = tuple(sorted((*sure[fits[0]].words, *concept.words)))
            sure[fits[0]] = Concept(words=grown, families=sure[fits[0]].families)
        else:
            left.append(concept)
    return [*sure.values(), *left]


def with_compounds(concepts: list[Concept], words: Sequence[str]) -> list[Concept]:
    """Return concepts with one for the compounds of each head, describing what the head does."""
    kinds: dict[str, list[str]] = {}
    for word in words:
        head = head_of(word)
        if head is not None:
            kinds.setdefault(head, []).append(word)
    families = {word: concept.families for concept in concepts for word in concept.words}
    return [
        *concepts,
        *(
            Concept(words=tuple(sorted(compounds)), families=families.get(head, ()), kind_of=head)
            for head, compounds in sorted(kinds.items())
        ),
    ]


def _told(
    profile: FloatArray, best: FloatArray, rival: FloatArray, families: tuple[Family, ...]
) -> tuple[Family, ...]:
    """Return the families that words describe.

    Size and shape come from the same outline: words that surely describe the one describe the
    other on weaker evidence, where no other words describe it better. A cube is no ball.
    But where few cubes were seen and most of them were red, that is what "red" says, not "cube".

    Args:
        profile: (F,) how surely the words describe each family.
        best: (F,) how surely the surest group does.
        rival: (F,) how surely the words do that are said together with these.
        families: their names.
    """
    main = (profile >= _SHARE_OF_BEST * profile.max(initial=0)) | (profile >= best)
    told = main & (profile >= _SHARE_OF_RIVAL * rival) & (profile >= _SIGNIFICANT)
    outline = np.array([family in {Family.SIZE, Family.SHAPE} for family in families], bool)
    if (told & outline).any():
        told |= outline & (profile >= best) & (profile >= _LIKELY)
    return tuple(family for family, yes in zip(families, told, strict=True) if yes)


def _join(
    word: str, groups: list[list[str]], profiles: dict[str, FloatArray], table: SegmentTable
) -> None:
    """Put a word into the group it is most like, or into a new one."""

    def likeness(group: list[str]) -> float:
        if any(_exclude_a_group(table, word, other) for other in group):
            return -1.0
        joint = np.sum([profiles[other] for other in group], axis=0)
        norms = float(np.linalg.norm(joint) * np.linalg.norm(profiles[word]))
        return float(joint @ profiles[word]) / norms if norms > 0 else -1.0

    best = max(groups, key=likeness, default=None)
    if best is not None and likeness(best) >= _LIKE:
        best.append(word)
    else:
        groups.append([word])


def _exclude_a_group(table: SegmentTable, one: str, other: str) -> bool:
    """Return whether two words cannot be of one group: what is said of things tells.

    Words that are said together are of different groups; and a word that always stands alone is
    a name for a thing, not one of the words that are said with others.
    """
    together = _are_said_together(table, one, other)
    return together or _is_alone(table, one) != _is_alone(table, other)


def _are_said_together(table: SegmentTable, one: str, other: str) -> bool:
    both = np.count_nonzero(table.bears[one] & table.bears[other])
    rarer = min(np.count_nonzero(table.bears[one]), np.count_nonzero(table.bears[other]))
    return bool(both > _SAID_TOGETHER * rarer)


def _is_alone(table: SegmentTable, word: str) -> bool:
    """Return whether a word is never said with another."""
    company = np.sum(list(table.bears.values()), axis=0)
    return bool((company[table.bears[word]] == 1).all())


def _profiles(
    table: SegmentTable, families: tuple[Family, ...], rng: np.random.Generator
) -> dict[str, FloatArray]:
    """Return for each word how surely it describes each family, in standard deviations."""
    apart = [_saturated_distances(table, family) for family in families]
    profiles = {}
    for word, bears in table.bears.items():
        shuffled = np.array([rng.permutation(bears) for _ in range(_PERMUTATIONS)])
        indicators = np.vstack([bears, shuffled]).astype(float)  # (1 + P, S)
        z = [_standing(_energies(indicators, distances)) for distances in apart]
        profiles[word] = np.maximum(z, 0.0)
    return profiles


def _standing(energies: FloatArray) -> float:
    """Return how far the first value stands above the others, in their standard deviations."""
    chance = energies[1:]
    spread = float(chance.std())
    return float(energies[0] - chance.mean()) / spread if spread > 1e-9 else 0.0


def _energies(indicators: FloatArray, distances: FloatArray) -> FloatArray:
    """Return mean distance to others less mean distance within, for each row of indicators.

    Source:
        Szekely and Rizzo 2004, the energy statistic, here with a bounded distance.
    """
    count = indicators.sum(axis=1)
    rest = indicators.shape[1] - count
    to_all = indicators @ distances
    within = (to_all * indicators).sum(axis=1) / np.maximum(count * (count - 1), 1)
    between = (to_all * (1 - indicators)).sum(axis=1) / np.maximum(count * rest, 1)
    energies: FloatArray = between - within
    return energies


def _saturated_distances(table: SegmentTable, family: Family) -> FloatArray:
    """Return (S, S) distances in one family, bounded by 1."""
    chosen = table.centres[:, [each is family for each in table.families]]
    squares = np.sum(chosen**2, axis=1)
    squared = np.maximum(squares[:, None] + squares[None] - 2 * chosen @ chosen.T, 0)
    distances: FloatArray = 1 - np.exp(-squared / chosen.shape[1] / (2 * _SATURATION**2))
    return distances


def _thinned(table: SegmentTable) -> SegmentTable:
    """Return at most some hundred segments, evenly taken."""
    step = -(-len(table.centres) // _MAX_SEGMENTS)
    if step <= 1:
        return table
    return SegmentTable(
        centres=table.centres[::step],
        families=table.families,
        bears={word: bears[::step] for word, bears in table.bears.items()},
    )
