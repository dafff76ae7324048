"""Synonyms and a person's own words, and what two people know put together.

A lexicon maps a word that somebody says to the word that is learnt ("mustard" to "yellow"). Each
person has one; that of the person "" holds for everyone whose own says nothing else.
"""

import json
from dataclasses import replace

import numpy as np

from grounding.errors import InputError
from grounding.symbols.compounds import head_of
from grounding.symbols.model import Group, Moments, SymbolModel

EVERYONE = ""


def call(model: SymbolModel, own: str, meaning: str, *, person: str = EVERYONE) -> SymbolModel:
    """Return the model in which a person calls `own` what is learnt as `meaning`.

    Raises:
        InputError: if nothing is learnt as `meaning`, or `own` is itself a learnt word.
    """
    learnt = understand(model, meaning, person=person)
    if learnt is None:
        known = ", ".join(sorted(model.words))
        raise InputError(f"no word {meaning!r}", where="lexicon", todo=f"name one of: {known}")
    if own in model.words:
        raise InputError(
            f"{own!r} has a meaning of its own", where="lexicon", todo="forget that word first"
        )
    lexicon = {**model.lexicons.get(person, {}), own: learnt}
    return replace(model, lexicons={**model.lexicons, person: lexicon})


def understand(model: SymbolModel, word: str, *, person: str = EVERYONE) -> str | None:
    """Return the learnt word that a person means, or None.

    The person's own words come first, then everyone's, then learnt words; a compound that was
    never learnt means what its head means.
    """
    for speaker in (person, EVERYONE):
        meaning = model.lexicons.get(speaker, {}).get(word)
        if meaning is not None:
            return meaning
    if word in model.words:
        return word
    head = head_of(word)
    return None if head is None else understand(model, head, person=person)


def exported(model: SymbolModel, *, person: str = EVERYONE) -> str:
    """Return a person's lexicon as JSON: own word -> learnt word."""
    return json.dumps(model.lexicons.get(person, {}), indent=1, sort_keys=True, ensure_ascii=False)


def merged(one: SymbolModel, other: SymbolModel) -> SymbolModel:
    """Return what two models know together: words that both know are learnt from both.

    A word of which both know exactly the same was copied from one to the other, and its patches
    count once. Two copies that both learnt more of a word count what they shared twice.

    Groups are the first model's; a word that only the other knows joins the group that most of
    its companions are in. Where lexicons differ, the first model's holds.

    Raises:
        InputError: if the models are over different features.
    """
    if one.features != other.features or not np.array_equal(one.unit, other.unit):
        raise InputError(
            "the models are over different features", where="merge", todo="fit both alike"
        )
    words = {**other.words, **one.words}
    known = one.words.keys() & other.words.keys()
    copied = {w for w in known if _is_same(one.words[w].moments, other.words[w].moments)}
    for name in known - copied:
        words[name] = replace(
            one.words[name],
            moments=one.words[name].moments.plus(other.words[name].moments),
            kept=one.words[name].kept + other.words[name].kept,
            dropped=one.words[name].dropped + other.words[name].dropped,
        )
    lexicons = {
        person: {**other.lexicons.get(person, {}), **one.lexicons.get(person, {})}
        for person in sorted({*one.lexicons, *other.lexicons})
    }
    return replace(
        one,
        words=words,
        groups=_merged_groups(one, other),
        anything=(
            max(one.anything, other.anything, key=lambda each: each.weight)
            if copied
            else one.anything.plus(other.anything)
        ),
        lexicons=lexicons,
        open_segments=(),
    )


def _is_same(a: Moments, b: Moments) -> bool:
    return a.weight == b.weight and bool(np.array_equal(a.mean, b.mean))


def _merged_groups(one: SymbolModel, other: SymbolModel) -> tuple[Group, ...]:
    groups = list(one.groups)
    known = set(one.words)
    for group in other.groups:
        new = [word for word in group.words if word not in known]
        shared = [len(set(group.words) & set(each.words)) for each in groups]
        if new and max(shared, default=0) > 0:
            place = shared.index(max(shared))
            grown = tuple(sorted((*groups[place].words, *new)))
            groups[place] = replace(groups[place], words=grown)
        elif new:
            taken = {each.name for each in groups}
            name = group.name if group.name not in taken else f"{group.name}-2"
            groups.append(replace(group, name=name, words=tuple(new)))
    return tuple(groups)
