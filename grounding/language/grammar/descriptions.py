"""Clauses that say or ask what is the case: no command, but understood as such."""

from typing import Final

from grounding.language.grammar.chart import Chart, Found
from grounding.language.grammar.rules import (
    adjective_phrase,
    finite_predicate,
    nominal,
    prep_phrase,
    simple_noun,
)
from grounding.language.grammar.tree import (
    Adjective,
    AdjectivePair,
    Clause,
    Description,
    Mood,
    Nominal,
    NounPhrase,
    PrepPhrase,
    Sentence,
    VerbPhrase,
)
from grounding.language.grammar.verbs import verb_phrases
from grounding.language.morphology import Form

_BE: Final = frozenset({"is", "are", "was", "were", "am", "'s", "be"})
_DOING: Final = frozenset({"do", "does", "did"})

Said = Adjective | AdjectivePair | PrepPhrase | Nominal


def described(chart: Chart, i: int) -> Found[Sentence]:
    """Yield statements of fact and questions about facts."""
    if chart.at(i).text in _BE:
        for subject, j in nominal(chart, i + 1):
            yield from _copular(chart, subject, i=j, verb=i, mood=Mood.QUESTION)
    elif chart.at(i).text in _DOING:
        for subject, j in simple_noun(chart, i + 1):
            yield from _acting(chart, subject, i=j, mood=Mood.QUESTION)
    if chart.at(i).text == "there" and chart.at(i + 1).text in _BE:
        for subject, j in nominal(chart, i + 2):
            yield from _copular(chart, subject, i=j, verb=i + 1, mood=Mood.STATEMENT)
    yield from _stated(chart, i)


def _stated(chart: Chart, i: int) -> Found[Sentence]:
    for subject, j in nominal(chart, i):
        places = [((), j)] + [((phrase,), k) for phrase, k in prep_phrase(chart, j)]
        for _, k in places:
            if chart.at(k).text in _BE:
                start = k + 1 + (chart.at(k + 1).text == "not")
                yield from _copular(chart, subject, i=start, verb=k, mood=Mood.STATEMENT)
            yield from _having(chart, subject, i=k)
            if not _speaks(subject):
                yield from _acting(chart, subject, i=k, mood=Mood.STATEMENT)


def _speaks(subject: Nominal) -> bool:
    """Whether a subject is the speaker or the listener, whose doings are commands."""
    return isinstance(subject, NounPhrase) and subject.head.lemma in ("i", "you", "we")


def _copular(
    chart: Chart, subject: Nominal, *, i: int, verb: int, mood: Mood
) -> Found[Description]:
    for said, end in _said(chart, i):
        yield Description(mood=mood, subject=subject, said=said, verb=chart.word(verb)), end


def _said(chart: Chart, i: int) -> Found[Said | None]:
    yield from adjective_phrase(chart, i)
    yield from prep_phrase(chart, i)
    yield from nominal(chart, i)
    yield None, i


def _having(chart: Chart, subject: Nominal, *, i: int) -> Found[Clause]:
    """Yield "you have the cube in your hand": a state, not a deed."""
    if not any(lemma == "have" for lemma, _ in chart.at(i).verbs):
        return
    for taken, j in nominal(chart, i + 1):
        phrases = [((), j)] + [((phrase,), k) for phrase, k in prep_phrase(chart, j)]
        for found, end in phrases:
            verb = VerbPhrase(
                verb=chart.word(i, lemma="have"), form=Form.PRESENT, end=chart.at(end - 1).end,
                object=taken, phrases=found,
            )  # fmt: skip
            yield Clause(mood=Mood.STATEMENT, predicate=verb, subject=subject), end


def _acting(chart: Chart, subject: Nominal, *, i: int, mood: Mood) -> Found[Clause]:
    """Yield what somebody else does: "the robot takes the cube"."""
    spoken = verb_phrases(chart, i, form=Form.PRESENT) if chart.at(i).verbs else ()
    for predicate, end in (*spoken, *finite_predicate(chart, i)):
        yield Clause(mood=mood, predicate=predicate, subject=subject), end
