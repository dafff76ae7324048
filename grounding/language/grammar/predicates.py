"""Predicates: verb phrases in a row, and verbs that bring another ("could", "try to")."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from grounding.language.grammar.adverbs import adverbs_at
from grounding.language.grammar.chart import Chart, Found, Rule
from grounding.language.grammar.nouns import opens_predicate
from grounding.language.grammar.rules import (
    base_predicate,
    finite_predicate,
    gerund_predicate,
    participle_predicate,
    simple_noun,
    single_base,
    single_finite,
    single_gerund,
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
from grounding.language.grammar.verbs import verb_phrases
from grounding.language.lexicon import CORRECTION
from grounding.language.morphology import Form
from grounding.language.words import Token

_TO_AFTER_BE: Final = frozenset({"going", "about", "able", "supposed", "ready", "meant", "sure"})

_single_participle = Rule[Predicate]("one predicate in the participle")


@base_predicate.define
def _base_predicate(chart: Chart, i: int) -> Found[Predicate]:
    yield from _row(chart, i, single=single_base, more=base_predicate)


@finite_predicate.define
def _finite_predicate(chart: Chart, i: int) -> Found[Predicate]:
    yield from _row(chart, i, single=single_finite, more=finite_predicate)


@gerund_predicate.define
def _gerund_predicate(chart: Chart, i: int) -> Found[Predicate]:
    yield from _row(chart, i, single=single_gerund, more=gerund_predicate)


@participle_predicate.define
def _participle_predicate(chart: Chart, i: int) -> Found[Predicate]:
    yield from _row(chart, i, single=_single_participle, more=participle_predicate)


def _row(
    chart: Chart, i: int, *, single: Rule[Predicate], more: Rule[Predicate]
) -> Found[Predicate]:
    for left, j in single(chart, i):
        denied = isinstance(left, Negation) and _spreads(chart, left)
        for word, k in connectors(chart, j):
            if denied and (word is None or word.lemma not in ("and", "or", "nor")):
                continue
            for right, end in more(chart, k):
                yield _paired(left, right=right, word=word, spreads=denied), end
        yield left, j


def _spreads(chart: Chart, denial: Negation) -> bool:
    """Whether a denial reaches over "and": "do not" does, "stop taking" ends with its gerund."""
    return denial.word.lemma not in chart.words.control["not_gerund"]


def _paired(left: Predicate, *, right: Predicate, word: Word | None, spreads: bool) -> Predicate:
    borrowed = _first_verb(right)
    if isinstance(left, VerbPhrase) and left.object is None and not left.phrases and borrowed:
        left = replace(left, object=borrowed.object)
    if isinstance(left, Negation) and spreads:
        body = PredicatePair(conjunction=word, left=left.body, right=right)
        return Negation(word=left.word, body=body)
    return PredicatePair(conjunction=word, left=left, right=right)


def _first_verb(predicate: Predicate) -> VerbPhrase | None:
    """Return the verb phrase that may lend its object: "pick up and move the cube"."""
    if isinstance(predicate, PredicatePair):
        return _first_verb(predicate.left)
    return predicate if isinstance(predicate, VerbPhrase) else None


def connectors(chart: Chart, i: int) -> Iterator[tuple[Word | None, int]]:
    """Yield the conjunction at a position, None for a pause or a run-on, and where it ends."""
    corrected = chart.after_correction(i)
    if corrected > i:
        yield chart.word(chart.after_pauses(i), lemma=CORRECTION), corrected
    j = chart.after_pauses(i)
    end = chart.after_phrase(j, name="conjunction_phrases")
    if end > j:
        yield chart.word(j), end
    if (chart.at(j).text, chart.at(j + 1).text) == ("and", "to"):
        yield chart.word(j), j + 2
    token = chart.at(j)
    if token.text in ("and", "then", "or", "but", "&", "plus"):
        yield chart.word(j), j + 1
    elif j > i or opens_predicate(chart, j):
        yield None, j


@single_base.define
def _base(chart: Chart, i: int) -> Found[Predicate]:
    adverbs, j = adverbs_at(chart, i)
    for predicate, end in _bare(chart, j, form=Form.BASE):
        yield with_adverbs(predicate, adverbs=adverbs), end


@single_gerund.define
def _gerund(chart: Chart, i: int) -> Found[Predicate]:
    adverbs, j = adverbs_at(chart, i)
    for predicate, end in _bare(chart, j, form=Form.GERUND):
        yield with_adverbs(predicate, adverbs=adverbs), end


@_single_participle.define
def _participle(chart: Chart, i: int) -> Found[Predicate]:
    adverbs, j = adverbs_at(chart, i)
    for predicate, end in _bare(chart, j, form=Form.PARTICIPLE):
        yield with_adverbs(predicate, adverbs=adverbs), end


@single_finite.define
def _finite(chart: Chart, i: int) -> Found[Predicate]:
    adverbs, j = adverbs_at(chart, i)
    found = (
        *_auxiliary(chart, j), *_bare(chart, j, form=Form.BASE), *_bare(chart, j, form=Form.PAST)
    )  # fmt: skip
    for predicate, end in found:
        yield with_adverbs(predicate, adverbs=adverbs), end


def with_adverbs(predicate: Predicate, *, adverbs: tuple[Adverb, ...]) -> Predicate:
    """Return a predicate that also holds the adverbs before it, on its first verb."""
    if not adverbs:
        return predicate
    if isinstance(predicate, PredicatePair):
        return replace(predicate, left=with_adverbs(predicate.left, adverbs=adverbs))
    if isinstance(predicate, VerbPhrase):
        return replace(predicate, adverbs=(*adverbs, *predicate.adverbs))
    return replace(predicate, body=with_adverbs(predicate.body, adverbs=adverbs))


def _bare(chart: Chart, i: int, *, form: Form) -> Found[Predicate]:
    """Yield a predicate whose verb stands at `i`, with no adverbs before it."""
    token = chart.at(i)
    start = _after_denial(chart, i)
    if start > i:
        for body, end in _SINGLE[form](chart, start):
            yield Negation(word=chart.word(i, lemma=_denying(token)), body=body), end
        return
    lemma = token.verb(form)
    if lemma == "do":
        yield from _do(chart, i)
    if lemma == "go" and chart.at(i + 1).text == "ahead":
        yield from _brought(chart, i + 2, by=chart.joined(i, i + 2))
    for candidate, kind in token.verbs:
        if kind is form:
            yield from _control(chart, i, lemma=candidate)
    yield from verb_phrases(chart, i, form=form)


def _after_denial(chart: Chart, i: int) -> int:
    """Return where "not", "never" or "by no means" ends, or `i`."""
    if chart.at(i).text in ("not", "never"):
        return i + 1
    return chart.after_phrase(i, name="negation_phrases")


def _denying(token: Token) -> str:
    return "never" if token.text == "never" else "not"


def _do(chart: Chart, i: int) -> Found[Predicate]:
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


def _control(chart: Chart, i: int, *, lemma: str) -> Found[Predicate]:
    """Yield a verb that brings another: "go and take", "try to", "want you to", "stop taking"."""
    kinds, verb, j = chart.words.control, chart.word(i, lemma=lemma), i + 1
    if lemma in kinds["and"] and (chart.at(j).text == "and" or lemma == "go"):
        yield from _brought(chart, j, by=verb)
    for body, end in to_predicate(chart, j):
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
            *(to_predicate(chart, j) if asks else ()),
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


def to_predicate(chart: Chart, i: int) -> Found[Predicate]:
    """Yield "to take the cube", with "not" before or behind "to"."""
    adverbs, j = adverbs_at(chart, i)
    denied = chart.at(j).text == "not"
    if chart.at(j + denied).text != "to":
        return
    for body, end in single_base(chart, j + denied + 1):
        inner = with_adverbs(body, adverbs=adverbs)
        yield (Negation(word=chart.word(j), body=inner) if denied else inner), end


def _auxiliary(chart: Chart, i: int) -> Found[Predicate]:
    """Yield predicates that begin with a modal or a form of "be", "have" or "do"."""
    token = chart.at(i)
    lemmas = {lemma for lemma, _ in token.verbs}
    if token.text in chart.words.control["modal"] or token.text in ("'d", "better"):
        yield from modal_predicate(chart, i)
    if "be" in lemmas:
        yield from _being(chart, i)
    if "have" in lemmas:
        yield from _plain(chart, i, body=_single_participle)
    if token.text in ("do", "did"):
        yield from _plain(chart, i, body=single_base)


def modal_predicate(chart: Chart, i: int) -> Found[Predicate]:
    """Yield "could take", "should not take": the modal stands at `i`."""
    for body, end in single_base(chart, i + 1):
        yield Control(verb=chart.word(i), modal=True, person=None, body=body), end


def _plain(chart: Chart, i: int, *, body: Rule[Predicate]) -> Found[Predicate]:
    j = i + 1 + (chart.at(i + 1).text == "got")
    if j == i + 2:
        for found, end in to_predicate(chart, j):
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
    found = (*to_predicate(chart, start), *single_gerund(chart, j))
    for body, end in found:
        inner = with_adverbs(body, adverbs=adverbs)
        if denied:
            yield Negation(word=chart.word(i + 1), body=inner), end
        else:
            yield Control(verb=None, modal=False, person=None, body=inner), end


_SINGLE: Final = {
    Form.BASE: single_base, Form.GERUND: single_gerund, Form.PARTICIPLE: _single_participle,
    Form.PAST: single_finite,
}  # fmt: skip
