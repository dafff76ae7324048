"""Noun phrases in a row: lists, what is excluded, what is taken back, what is said again."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from grounding.language.grammar.chart import Chart, Found
from grounding.language.grammar.nouns import opens_predicate
from grounding.language.grammar.rules import nominal, simple_noun
from grounding.language.grammar.tree import (
    Adjective,
    Kept,
    Kind,
    Nominal,
    NounPair,
    NounPhrase,
    Word,
)
from grounding.language.lexicon import CORRECTION

_SUBJECTS: Final = frozenset({"i", "we", "he", "she", "they", "you"})
_REACH: Final = 5

_Link = tuple[int, Word | None, Kept]


@nominal.define
def _nominal(chart: Chart, i: int) -> Found[Nominal]:
    denied = chart.at(i).text == "not"
    for left, j in simple_noun(chart, i + denied):
        links = _contrasts(chart, j) if denied else _noun_conjunctions(chart, j)
        for at, word, kept in links:
            for right, end in nominal(chart, at):
                first = _first(right)
                if word is None and _restates(chart, left, right=right):
                    yield _merged(left, right=first), chart.after_pauses(end)
                    continue
                unmarked = word is None and first is right and first.determiner is None
                if unmarked or first.head.lemma in _SUBJECTS:
                    continue
                pair = NounPair(
                    conjunction=word, left=left, right=right, start=left.start, end=right.end,
                    kept=kept,
                )  # fmt: skip
                yield pair, end
        if not denied:
            yield left, j


def _restates(chart: Chart, left: NounPhrase, *, right: Nominal) -> bool:
    """Whether "the blue one" behind a pause says more of what was named: "the cup, the blue one".

    It does not where it tells another colour: that makes a list.
    """
    if not isinstance(right, NounPhrase) or right.kind is not Kind.ONE or left.plural:
        return False
    classes = chart.words.classes
    said, more = (
        {
            classes.get(each.word.lemma, each.word.lemma)
            for each in noun.modifiers
            if isinstance(each, Adjective)
        }
        for noun in (left, right)
    )
    return right.determiner is not None and said.isdisjoint(more)


def _merged(left: NounPhrase, *, right: NounPhrase) -> NounPhrase:
    adjectives = tuple(each for each in right.modifiers if isinstance(each, Adjective))
    return replace(left, after=(*left.after, *adjectives, *right.after), end=right.end)


def _first(nominal: Nominal) -> NounPhrase:
    return nominal if isinstance(nominal, NounPhrase) else _first(nominal.left)


def _contrasts(chart: Chart, i: int) -> Iterator[_Link]:
    """Yield the link of "not the red cube but the blue one"."""
    j = chart.after_pauses(i)
    if chart.at(j).text == "but":
        yield j + 1, chart.word(j, lemma=CORRECTION), Kept.RIGHT


def _noun_conjunctions(chart: Chart, i: int) -> Iterator[_Link]:
    """Yield where a conjoined noun phrase may start, its conjunction and which are meant."""
    paused = chart.at(i).is_a("pause")
    j = i + paused
    excluded = _after_exclusion(chart, j, end=i)
    if excluded > j:
        yield excluded, chart.joined(j, excluded), Kept.LEFT
        return
    corrected = _after_correction(chart, i)
    if corrected > i:
        yield corrected, chart.word(j, lemma=CORRECTION), Kept.RIGHT
    end = chart.after_phrase(j, name="conjunction_phrases")
    if end == j and chart.at(j).text in ("and", "or", "plus", "&", "nor"):
        end = j + 1
    if end == j and chart.at(j).text == "then" and chart.at(j + 1).is_a("determiners"):
        end = j + 1
    if end > j and not opens_predicate(chart, end):
        yield end, chart.joined(j, end), Kept.BOTH
    elif end == j and paused and not opens_predicate(chart, end):
        yield end, None, Kept.BOTH


def _after_correction(chart: Chart, i: int) -> int:
    """Return where "no, wait" ends, or ", actually" before another noun phrase, else `i`."""
    j = chart.after_pauses(i)
    if j > i and chart.at(j).text == "actually":
        return chart.after_pauses(j + 1)
    return chart.after_correction(i)


def _after_exclusion(chart: Chart, i: int, *, end: int) -> int:
    """Return where "not", "but not", or "but" after "all the cubes" ends, else `i`."""
    but = chart.at(i).text == "but"
    if chart.at(i + but).text == "not":
        return i + but + 1
    return i + (but and _names_all(chart, end))


def _names_all(chart: Chart, end: int) -> bool:
    """Whether the noun phrase before holds "all", "every" or the like: "all cubes but one"."""
    words = (chart.at(k).text for k in range(max(0, end - _REACH), end))
    return any(text in ("all", "every", "each", "any") for text in words)
