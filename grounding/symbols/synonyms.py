"""Words that mean the same: found after a fit, and kept as one word and another name for it."""

from dataclasses import replace
from typing import Final

import numpy as np

from grounding.symbols.classify import KnownGroup, know_group
from grounding.symbols.lexicon import EVERYONE
from grounding.symbols.model import SymbolModel

_ENOUGH: Final = 5.0  # effective patches of each word


def join_synonyms(model: SymbolModel) -> SymbolModel:
    """Return the model in which words of one group that lie together are one word.

    Two words are one when the middle of each is nearer to the other's than a typical patch of a
    word is to its own middle, and most patches of both were believed. The word with more patches
    stays; the other becomes everyone's name for it.
    """
    names = dict(model.lexicons.get(EVERYONE, {}))
    for group in model.groups:
        known = know_group(model, group)
        if known is None or not group.is_sure or not len(group.distances):
            continue
        names |= _pairs(model, known)
    joined = model
    for word, same in names.items():
        joined = _joined(joined, word, same)
    return replace(joined, lexicons={**model.lexicons, EVERYONE: names}) if names else model


def _pairs(model: SymbolModel, known: KnownGroup) -> dict[str, str]:
    """Return word -> the word with more patches that means the same."""
    typical = float(np.median(known.group.distances))
    apart = np.sqrt(known.density.squared_distances(known.density.means))  # (K, K)
    order = sorted(known.words, key=lambda word: -model.words[word].moments.weight)
    found: dict[str, str] = {}
    for place, word in enumerate(order):
        for other in order[:place]:
            one, two = known.words.index(word), known.words.index(other)
            near = max(apart[one, two], apart[two, one]) < typical
            if near and other not in found and _trusted(model, word) and _trusted(model, other):
                found[word] = other
                break
    return found


def _trusted(model: SymbolModel, word: str) -> bool:
    known = model.words[word]
    return known.kept > known.dropped and known.moments.effective >= _ENOUGH


def _joined(model: SymbolModel, word: str, same: str) -> SymbolModel:
    one, other = model.words[same], model.words[word]
    both = replace(
        one,
        moments=one.moments.plus(other.moments),
        kept=one.kept + other.kept,
        dropped=one.dropped + other.dropped,
    )
    words = {name: each for name, each in model.words.items() if name != word}
    groups = tuple(
        replace(group, words=tuple(each for each in group.words if each != word))
        for group in model.groups
    )
    return replace(model, words={**words, same: both}, groups=groups)
