"""Sentences: commands, statements and questions, with what is said around them."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from grounding.language.grammar.adverbs import adverbs_at
from grounding.language.grammar.chart import Chart, Found, Rule
from grounding.language.grammar.descriptions import described
from grounding.language.grammar.predicates import connectors
from grounding.language.grammar.rules import (
    base_predicate,
    clause,
    finite_predicate,
    gerund_predicate,
    nominal,
    prep_phrase,
    simple_noun,
)
from grounding.language.grammar.subordinate import subordinated
from grounding.language.grammar.tails import tail_of_others
from grounding.language.grammar.tree import (
    Adverb,
    Clause,
    ClausePair,
    Control,
    Fragment,
    Kind,
    Mood,
    Nominal,
    Predicate,
    PredicatePair,
    PrepPhrase,
    Sentence,
    VerbPhrase,
)
from grounding.language.morphology import Form
from grounding.language.verbs import VerbTable
from grounding.language.words import Token

_SPEAKERS: Final = frozenset({"i", "you", "we"})

Reading = tuple[Mood, Nominal | None, Predicate, int]

_clauses = Rule[Sentence]("clauses in a row")


def readings(tokens: list[Token], *, verbs: VerbTable) -> list[Sentence]:
    """Return the readings of a whole sentence, the preferred first."""
    chart = Chart(tokens=tokens, verbs=verbs)
    return [sentence for sentence, end in _clauses(chart, 0) if _closed(chart, end) == len(tokens)]


def _closed(chart: Chart, i: int) -> int:
    """Skip what may close a sentence: pauses, polite words, a name that is called."""
    while chart.at(i).is_a("pause") or (i > 1 and chart.at(i).text in ("and", "then", "but")):
        i += 1
    _, j = adverbs_at(chart, i)
    if j == i and chart.at(i - 1).is_a("pause") and i + 1 == len(chart.tokens) > 2:
        j = i + (bool(chart.at(i).noun) or not chart.at(i).known)
    return _closed(chart, j) if j > i else i


@_clauses.define
def _all_clauses(chart: Chart, i: int) -> Found[Sentence]:
    for left, j in subordinated(chart, i):
        for word, k in connectors(chart, j):
            for right, end in _clauses(chart, k):
                yield ClausePair(conjunction=word, left=left, right=right), end
        yield left, j


@clause.define
def _one_clause(chart: Chart, i: int) -> Found[Sentence]:
    adverbs, j = _opening(chart, i)
    yield from _commanding(chart, j, adverbs=adverbs)
    for called in _called(chart, j):
        more, k = _opening(chart, called)
        yield from _commanding(chart, k, adverbs=(*adverbs, *more))
    yield from described(chart, j)
    for noun, end in nominal(chart, j):
        yield Fragment(nominal=noun), end


def _opening(chart: Chart, i: int) -> tuple[tuple[Adverb, ...], int]:
    """Skip the markers, conjunctions and pauses that a clause opens with."""
    found: list[Adverb] = []
    first = i == 0
    while True:
        adverbs, j = adverbs_at(chart, i)
        found.extend(adverbs)
        opens = chart.at(j).is_a("pause") or (first and chart.at(j).text in ("and", "but"))
        if not opens and j == i:
            return tuple(found), j
        i = j + opens


def _called(chart: Chart, i: int) -> Iterator[int]:
    """Yield where a clause goes on behind the name of whom it is said to: "robot, take it"."""
    for k in (i + 1, i + 2, i + 3):
        if all(_may_call(chart.at(n)) for n in range(i, k)) and chart.at(k).is_a("pause"):
            yield k + 1
    name, following = chart.at(i), chart.at(adverbs_at(chart, i + 1)[1])
    person = name.noun in chart.words.animate or (not name.known and name.capital)
    if person and not name.plural and following.verb(Form.BASE):
        yield i + 1


def _may_call(token: Token) -> bool:
    """Whether a word may be part of what somebody is called: "robot", "hey you", "step 1"."""
    if token.text == "you" or token.is_a("cardinals") or token.is_a("determiners"):
        return True
    return bool(token.noun or (token.text and not token.known))


def _commanding(chart: Chart, i: int, *, adverbs: tuple[Adverb, ...]) -> Found[Sentence]:
    """Yield the clauses that may command something, with phrases put to the front."""
    if chart.after_phrase(i, name="prepositions") == i:  # "close to the cup put it" closes nothing
        for mood, subject, predicate, end in _moods(chart, i):
            yield Clause(mood=mood, predicate=predicate, subject=subject, adverbs=adverbs), end
    for fronted, j in _fronted(chart, i):
        for mood, subject, predicate, end in _moods(chart, j):
            moved = _with_fronted(predicate, fronted=fronted)
            yield Clause(mood=mood, predicate=moved, subject=subject, adverbs=adverbs), end


def _moods(chart: Chart, i: int) -> Iterator[Reading]:
    yield from _led(chart, i)
    for predicate, end in base_predicate(chart, i):
        yield Mood.COMMAND, None, predicate, end
    if chart.at(i).text in _SPEAKERS:
        for subject, j in simple_noun(chart, i):
            for predicate, end in finite_predicate(chart, j):
                yield Mood.STATEMENT, subject, predicate, end
    yield from _asked(chart, i)
    for predicate, end in gerund_predicate(chart, i):
        yield Mood.STATEMENT, None, predicate, end
    yield from _should_be(chart, i)


def _led(chart: Chart, i: int) -> Iterator[Reading]:
    """Yield commands behind a fixed opening: "do you think you could", "how about"."""
    end = chart.after_phrase(i, name="leads_base")
    if end > i:
        start = end + (chart.at(end).text in _SPEAKERS)
        for predicate, after in base_predicate(chart, start):
            yield Mood.COMMAND, None, predicate, after
    end = chart.after_phrase(i, name="leads_gerund")
    if end > i:
        for predicate, after in gerund_predicate(chart, end):
            yield Mood.COMMAND, None, predicate, after


def _asked(chart: Chart, i: int) -> Iterator[Reading]:
    """Yield "could you take the cube", "can't you take it": a modal, its subject, the rest."""
    if chart.at(i).text not in chart.words.control["modal"]:
        return
    for subject, j in simple_noun(chart, i + 1 + (chart.at(i + 1).text == "not")):
        if subject.kind is not Kind.PRONOUN:
            continue
        for body, end in base_predicate(chart, j):
            control = Control(verb=chart.word(i), modal=True, person=None, body=body)
            yield Mood.QUESTION, subject, control, end


def _should_be(chart: Chart, i: int) -> Iterator[Reading]:
    """Yield "the cube should be put on the tray", "the box has to be opened"."""
    for subject, j in simple_noun(chart, i):
        k = j + 1 + (chart.at(j + 1).text == "to")
        lemma = chart.at(k + 1).verb(Form.PARTICIPLE)
        if not _obliges(chart, j) or chart.at(k).text != "be" or not lemma:
            continue
        for tail, end in tail_of_others(chart, k + 2):
            phrase = VerbPhrase(
                verb=chart.word(k + 1, lemma=lemma), form=Form.PARTICIPLE, object=subject,
                end=chart.at(end - 1).end, particle=tail.particle, phrases=tail.phrases,
                adverbs=tail.adverbs, passive=True,
            )  # fmt: skip
            modal = chart.word(j, lemma="should")
            control = Control(verb=modal, modal=True, person=None, body=phrase)
            yield Mood.COMMAND, None, control, end


def _obliges(chart: Chart, i: int) -> bool:
    """Whether "should", "must", "needs to" or "has to" stands here."""
    text = chart.at(i).text
    if chart.at(i + 1).text == "to":
        return text in ("need", "needs", "have", "has", "ought", "is", "are")
    return text in ("should", "must", "shall")


def _fronted(chart: Chart, i: int) -> Found[tuple[PrepPhrase, ...]]:
    for phrase, j in prep_phrase(chart, i):
        for more, end in _fronted(chart, j):
            yield (phrase, *more), end
        after = j + chart.at(j).is_a("pause")
        _, end = adverbs_at(chart, after)
        yield (phrase,), end


def _with_fronted(predicate: Predicate, *, fronted: tuple[PrepPhrase, ...]) -> Predicate:
    """Return a predicate whose first verb also holds the phrases before it."""
    if isinstance(predicate, VerbPhrase):
        return replace(predicate, fronted=fronted)
    if isinstance(predicate, PredicatePair):
        return replace(predicate, left=_with_fronted(predicate.left, fronted=fronted))
    return replace(predicate, body=_with_fronted(predicate.body, fronted=fronted))
