"""Inflection of English by rule: which forms a lemma has, and which lemma a plural comes from."""

from collections.abc import Iterator, Mapping
from enum import StrEnum
from typing import Final

_VOWELS: Final = "aeiou"
_HISSES: Final = ("s", "x", "z", "ch", "sh")


class Degree(StrEnum):
    """The degree of an adjective."""

    POSITIVE = "positive"
    COMPARATIVE = "comparative"
    SUPERLATIVE = "superlative"


class Form(StrEnum):
    """The form of a verb."""

    BASE = "base"
    PRESENT = "present"
    PAST = "past"
    PARTICIPLE = "participle"
    GERUND = "gerund"


VerbForms = Mapping[str, tuple[tuple[str, Form], ...]]
"""A form as it is spoken -> every (lemma, form) it may be."""


def inflections(lemma: str, *, irregular: str = "") -> Iterator[tuple[str, Form]]:
    """Yield every form of a verb; `irregular` holds its past and its participle."""
    past, participle = irregular.split() if irregular else (_with(lemma, "ed"),) * 2
    yield lemma, Form.BASE
    yield _with_s(lemma), Form.PRESENT
    yield past, Form.PAST
    yield participle, Form.PARTICIPLE
    yield _gerund(lemma), Form.GERUND


def degrees(lemma: str) -> Iterator[tuple[str, tuple[str, Degree]]]:
    """Yield the comparative and the superlative that an adjective forms with an ending."""
    yield _with(lemma, "er"), (lemma, Degree.COMPARATIVE)
    yield _with(lemma, "est"), (lemma, Degree.SUPERLATIVE)


def singular_candidates(word: str) -> Iterator[str]:
    """Yield what a regular plural may come from, the likeliest first."""
    if len(word) < 3 or not word.endswith("s") or word.endswith(("ss", "us", "is")):
        return
    if word.endswith("ies") and len(word) > 4:
        yield word[:-3] + "y"
    if word.endswith("oes") or (word.endswith("es") and word[:-2].endswith(_HISSES)):
        yield word[:-2]
    yield word[:-1]


def _with_s(lemma: str) -> str:
    if lemma.endswith("y") and lemma[-2] not in _VOWELS:
        return lemma[:-1] + "ies"
    return lemma + ("es" if lemma.endswith((*_HISSES, "o")) else "s")


def _gerund(lemma: str) -> str:
    if lemma.endswith("ie"):
        return lemma[:-2] + "ying"
    return lemma + "ing" if lemma.endswith(("ee", "ye")) or lemma == "be" else _with(lemma, "ing")


def _with(lemma: str, ending: str) -> str:
    """Return a lemma with an ending that begins with a vowel: drops e, doubles, turns y to i."""
    if lemma.endswith("e"):
        return lemma[:-1] + ending
    if lemma.endswith("y") and lemma[-2] not in _VOWELS and ending != "ing":
        return lemma[:-1] + "i" + ending
    return lemma + lemma[-1] + ending if _doubles(lemma) else lemma + ending


def _doubles(lemma: str) -> bool:
    """Whether the last consonant is doubled: one stressed syllable, as in "put" and "big"."""
    if len(lemma) < 3 or lemma[-1] in _VOWELS + "wxy" or lemma[-2] not in _VOWELS:
        return False
    vowels = sum(letter in _VOWELS for letter in lemma.removeprefix("qu"))
    return lemma[-3] not in _VOWELS and vowels == 1
