"""Predicates: verb phrases in a row, with adverbs before them, denied or not."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from grounding.language.grammar.adverbs import adverbs_at
from grounding.language.grammar.chart import Chart, Found, Rule
from grounding.language.grammar.control import (
    controlling,
    doing,
    with_adverbs,
    with_auxiliary,
)
from grounding.language.grammar.nouns import opens_predicate
from grounding.language.grammar.rules import (
    base_predicate,
    finite_predicate,
    gerund_predicate,
    participle_predicate,
    single_base,
    single_finite,
    single_gerund,
    single_participle,
)
from grounding.language.grammar.tree import (
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

_SPREADING: Final = frozenset({"and", "or", "nor", "&", "plus"})


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
    yield from _row(chart, i, single=single_participle, more=participle_predicate)


def _row(
    chart: Chart, i: int, *, single: Rule[Predicate], more: Rule[Predicate]
) -> Found[Predicate]:
    for left, j in single(chart, i):
        denied = _denies(chart, left)
        outright = denied and isinstance(left, Negation)
        for word, k in connectors(chart, j):
            links = word is not None and word.lemma in _SPREADING
            if outright and not links:
                continue
            for right, end in more(chart, k):
                spreads = denied and links and (outright or not _has_modal(right))
                yield _paired(left, right=right, word=word, spreads=spreads), end
        yield left, j


def _denies(chart: Chart, predicate: Predicate) -> bool:
    """Whether a denial in a predicate reaches over "and".

    "Do not" and "you must not" do, "stop taking" ends with its gerund.
    """
    if isinstance(predicate, Control):
        return _denies(chart, predicate.body)
    return isinstance(predicate, Negation) and (
        predicate.word.lemma not in chart.words.control["not_gerund"]
    )


def _has_modal(predicate: Predicate) -> bool:
    """Whether a predicate has a modal of its own: "must not take this and should take that"."""
    if isinstance(predicate, PredicatePair):
        return _has_modal(predicate.left)
    return isinstance(predicate, Control) and predicate.modal


def _paired(left: Predicate, *, right: Predicate, word: Word | None, spreads: bool) -> Predicate:
    borrowed = _first_verb(right)
    if isinstance(left, VerbPhrase) and left.object is None and not left.phrases and borrowed:
        left = replace(left, object=borrowed.object)
    if isinstance(left, Control) and spreads:
        return replace(left, body=_paired(left.body, right=right, word=word, spreads=True))
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
    yield from _in_form(chart, i, form=Form.BASE)


@single_gerund.define
def _gerund(chart: Chart, i: int) -> Found[Predicate]:
    yield from _in_form(chart, i, form=Form.GERUND)


@single_participle.define
def _participle(chart: Chart, i: int) -> Found[Predicate]:
    yield from _in_form(chart, i, form=Form.PARTICIPLE)


@single_finite.define
def _finite(chart: Chart, i: int) -> Found[Predicate]:
    adverbs, j = adverbs_at(chart, i)
    for predicate, end in with_auxiliary(chart, j):
        yield with_adverbs(predicate, adverbs=adverbs), end
    yield from _in_form(chart, i, form=Form.BASE)
    yield from _in_form(chart, i, form=Form.PAST)


def _in_form(chart: Chart, i: int, *, form: Form) -> Found[Predicate]:
    adverbs, j = adverbs_at(chart, i)
    for predicate, end in _bare(chart, j, form=form):
        yield with_adverbs(predicate, adverbs=adverbs), end


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
        yield from doing(chart, i)
    for candidate, kind in token.verbs:
        if kind is form:
            yield from controlling(chart, i, lemma=candidate)
    yield from verb_phrases(chart, i, form=form)


def _after_denial(chart: Chart, i: int) -> int:
    """Return where "not", "never" or "by no means" ends, or `i`."""
    if chart.at(i).text in ("not", "never"):
        return i + 1
    return chart.after_phrase(i, name="negation_phrases")


def _denying(token: Token) -> str:
    return "never" if token.text == "never" else "not"


_SINGLE: Final = {
    Form.BASE: single_base, Form.GERUND: single_gerund, Form.PARTICIPLE: single_participle,
    Form.PAST: single_finite,
}  # fmt: skip
