"""Clauses that say when, why or on what condition the rest of a sentence holds."""

from collections.abc import Iterator
from typing import Final

from grounding.language.grammar.chart import Chart, Found, Rule
from grounding.language.grammar.rules import clause, simple_noun, single_finite, single_gerund
from grounding.language.grammar.tails import tail_of_others
from grounding.language.grammar.tree import (
    Clause,
    Description,
    Fragment,
    Mood,
    Sentence,
    Subordination,
    VerbPhrase,
    Word,
)
from grounding.language.morphology import Form

_SPEAKERS: Final = frozenset({"i", "you", "we"})

subordinated = Rule[Sentence]("one clause with what says when, why or on what condition")
_side = Rule[Sentence]("a clause behind a word that subordinates it")


@subordinated.define
def _subordinated(chart: Chart, i: int) -> Found[Sentence]:
    yield from _led_by_side(chart, i)
    for main, j in clause(chart, i):
        yield from _with_sides(chart, main, i=j)
        yield main, j


def _led_by_side(chart: Chart, i: int) -> Found[Sentence]:
    """Yield "after you take the cube, put it down"."""
    opening = i
    while chart.at(opening).text in ("and", "then", "so", "now", "but", ",", "please"):
        opening += 1
    for word, j in _subordinators(chart, opening):
        for side, k in _side(chart, j):
            for main, end in subordinated(chart, chart.after_pauses(k)):
                if not isinstance(main, Fragment):
                    yield Subordination(word=word, main=main, side=side), end


def _with_sides(chart: Chart, main: Sentence, *, i: int) -> Found[Sentence]:
    """Yield "put it down after you take the cube"."""
    for word, j in _subordinators(chart, chart.after_pauses(i)):
        for side, end in _side(chart, j):
            yield Subordination(word=word, main=main, side=side), end


def _subordinators(chart: Chart, i: int) -> Iterator[tuple[Word, int]]:
    if chart.after_phrase(i, name="phrases") > i:
        return
    end = chart.after_phrase(i, name="subordinators")
    if end > i:
        yield chart.joined(i, end), end


@_side.define
def _side_clause(chart: Chart, i: int) -> Found[Sentence]:
    yield from _single(chart, i)
    for found, end in clause(chart, i):
        if isinstance(found, (Clause, Description)) and found.mood is Mood.STATEMENT:
            yield found, end
    yield from _unknown(chart, i)


def _unknown(chart: Chart, i: int) -> Found[Sentence]:
    """Yield "it wugs", "the bell rings": somebody else's doing, with a word that is no verb."""
    for subject, j in simple_noun(chart, i):
        if not chart.at(j).text or (chart.at(j).known and not chart.at(j).plural):
            continue
        for tail, end in tail_of_others(chart, j + 1):
            verb = VerbPhrase(
                verb=chart.word(j, known=False), form=Form.PRESENT, end=chart.at(end - 1).end,
                phrases=tail.phrases, adverbs=tail.adverbs, particle=tail.particle,
            )  # fmt: skip
            yield Clause(mood=Mood.STATEMENT, predicate=verb, subject=subject), end


def _single(chart: Chart, i: int) -> Found[Sentence]:
    """Yield a clause with one predicate; the next may be the main one."""
    for predicate, end in single_gerund(chart, i):
        yield Clause(mood=Mood.STATEMENT, predicate=predicate, subject=None), end
    for subject, j in simple_noun(chart, i) if chart.at(i).text in _SPEAKERS else ():
        for predicate, end in single_finite(chart, j):
            yield Clause(mood=Mood.STATEMENT, predicate=predicate, subject=subject), end
