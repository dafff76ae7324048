"""Verbs that bring another: "could take", "try to take", "want you to take", "stop taking"."""

from dataclasses import replace
from typing import Final

from grounding.language.grammar.adverbs import adverbs_at
from grounding.language.grammar.chart import Chart, Found, Rule
from grounding.language.grammar.rules import (
    gerund_predicate,
    simple_noun,
    single_base,
    single_gerund,
    single_participle,
)
from grounding.language.grammar.tree import (
    Adverb,
    Control,
    Negation,
    Predicate,
    PredicatePair,
    VerbPhrase,
    Word,
)

_TO_AFTER_BE: Final = frozenset({"going", "about", "able", "supposed", "ready", "meant", "sure"})


def with_adverbs(predicate: Predicate, *, adverbs: tuple[Adverb, ...]) -> Predicate:
    """Return a predicate that also holds the adverbs before it, on its first verb."""
    if not adverbs:
        return predicate
    if isinstance(predicate, PredicatePair):
        return replace(predicate, left=with_adverbs(predicate.left, adverbs=adverbs))
    if isinstance(predicate, VerbPhrase):
        return replace(predicate, adverbs=(*adverbs, *predicate.adverbs))
    return replace(predicate, body=with_adverbs(predicate.body, adverbs=adverbs))


def doing(chart: Chart, i: int) -> Found[Predicate]:
    """Yield "do take" and "do not take"."""
    j = i + 1 + (chart.at(i + 1).text == "you")
    if chart.at(j).text in ("not", "never"):
        k = j + 1 + (chart.at(j + 1).text == "you")
        for body, end in single_base(chart, k):
            yield Negation(word=chart.joined(i, j + 1), body=body), end
    else:
        for body, end in single_base(chart, i + 1):
            yield Control(verb=None, modal=False, person=None, body=body), end


def _brought(chart: Chart, i: int, *, by: Word) -> Found[Predicate]:
    """Yield "go ahead and take", "go and get", "go get"."""
    start = i + (chart.at(i).text == "and")
    for body, after in single_base(chart, start):
        yield Control(verb=by, modal=False, person=None, body=body), after


def controlling(chart: Chart, i: int, *, lemma: str) -> Found[Predicate]:
    """Yield a verb that brings another: "go and take", "try to", "want you to", "stop taking"."""
    kinds, verb, j = chart.words.control, chart.word(i, lemma=lemma), i + 1
    if lemma == "go" and chart.at(j).text == "ahead":
        yield from _brought(chart, j + 1, by=chart.joined(i, j + 1))
    if lemma in kinds["and"] and (chart.at(j).text == "and" or lemma == "go"):
        yield from _brought(chart, j, by=verb)
    for body, end in _infinitive(chart, j):
        if lemma in kinds["to"]:
            yield Control(verb=verb, modal=False, person=None, body=body), end
        elif lemma in kinds["not_to"]:
            yield Negation(word=verb, body=body), end
    yield from _with_person(chart, j, verb=verb)
    yield from _with_gerund(chart, j, verb=verb)


def _with_person(chart: Chart, i: int, *, verb: Word) -> Found[Predicate]:
    """Yield "want you to take" and "help me take"."""
    kinds = chart.words.control
    asks, helps = verb.lemma in kinds["person_to"], verb.lemma in kinds["person_base"]
    for person, j in simple_noun(chart, i) if asks or helps else ():
        bodies = (
            *(_infinitive(chart, j) if asks else ()),
            *(single_base(chart, j) if helps else ()),
        )
        for body, end in bodies:
            whom = None if helps else person
            yield Control(verb=verb, modal=False, person=whom, body=body), end


def _with_gerund(chart: Chart, i: int, *, verb: Word) -> Found[Predicate]:
    """Yield "start taking", "start by taking" and, denied, "stop taking"."""
    kinds = chart.words.control
    by = chart.at(i).text in ("by", "from", "with")
    kept = verb.lemma in kinds["by_gerund" if by else "gerund"]
    if kept or verb.lemma in kinds["not_gerund"]:
        for body, end in gerund_predicate(chart, i + by):
            if kept:
                yield Control(verb=verb, modal=False, person=None, body=body), end
            else:
                yield Negation(word=verb, body=body), end


def _infinitive(chart: Chart, i: int) -> Found[Predicate]:
    """Yield "to take the cube", with "not" before or behind "to"."""
    adverbs, j = adverbs_at(chart, i)
    denied = chart.at(j).text == "not"
    if chart.at(j + denied).text != "to":
        return
    for body, end in single_base(chart, j + denied + 1):
        inner = with_adverbs(body, adverbs=adverbs)
        yield (Negation(word=chart.word(j), body=inner) if denied else inner), end


def with_auxiliary(chart: Chart, i: int) -> Found[Predicate]:
    """Yield predicates that begin with a modal or a form of "be", "have" or "do"."""
    token = chart.at(i)
    lemmas = {lemma for lemma, _ in token.verbs}
    if token.text in chart.words.control["modal"] or token.text in ("'d", "better"):
        yield from _with_modal(chart, i)
    if "be" in lemmas:
        yield from _being(chart, i)
    if "have" in lemmas:
        yield from _plain(chart, i, body=single_participle)
    if token.text in ("do", "did"):
        yield from _plain(chart, i, body=single_base)


def _with_modal(chart: Chart, i: int) -> Found[Predicate]:
    """Yield "could take", "should not take": the modal stands at `i`."""
    for body, end in single_base(chart, i + 1):
        yield Control(verb=chart.word(i), modal=True, person=None, body=body), end


def _plain(chart: Chart, i: int, *, body: Rule[Predicate]) -> Found[Predicate]:
    """Yield "have taken", "have got to take", "did take"."""
    j = i + 1 + (chart.at(i + 1).text == "got")
    if j == i + 2:
        for found, end in _infinitive(chart, j):
            yield (
                Control(verb=chart.word(i, lemma="have"), modal=True, person=None, body=found),
                end,
            )
    for found, end in body(chart, i + 1):
        denied = isinstance(found, Negation)
        yield (found if denied else Control(verb=None, modal=False, person=None, body=found)), end


def _being(chart: Chart, i: int) -> Found[Predicate]:
    """Yield "am taking", "am not taking", "am going to take", "am to take"."""
    denied = chart.at(i + 1).text == "not"
    adverbs, j = adverbs_at(chart, i + 1 + denied)
    start = j + (chart.at(j).text in _TO_AFTER_BE)
    found = (*_infinitive(chart, start), *single_gerund(chart, j))
    for body, end in found:
        inner = with_adverbs(body, adverbs=adverbs)
        if denied:
            yield Negation(word=chart.word(i + 1), body=inner), end
        else:
            yield Control(verb=None, modal=False, person=None, body=inner), end
