"""Verb phrases: verb, particle, recipient, object and what follows, by the verb's frame."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

from grounding.language.grammar.adverbs import adverbs_at
from grounding.language.grammar.chart import Chart, Found
from grounding.language.grammar.nouns import opens_predicate, pronoun_person
from grounding.language.grammar.rules import (
    nominal,
    simple_noun,
    single_prep_phrase,
)
from grounding.language.grammar.tails import tail_of_others, tail_of_taking
from grounding.language.grammar.tree import (
    Kind,
    Nominal,
    NounPair,
    NounPhrase,
    Predicate,
    PredicatePair,
    PrepPhrase,
    VerbPhrase,
    Word,
)
from grounding.language.morphology import Form
from grounding.language.verbs import Frame

_LEFT_TO_CONTROL: Final = frozenset({"be", "have", "do"})
_BEFORE_OBJECT: Final = frozenset(
    {
        "up",
        "down",
        "away",
        "back",
        "out",
        "off",
        "over",
        "apart",
        "aside",
        "together",
        "around",
        "open",
        "shut",
    }
)


def verb_phrases(chart: Chart, i: int, *, form: Form) -> Found[Predicate]:
    """Yield the verb phrases whose verb stands at `i` in a form."""
    token = chart.at(i)
    lemmas = [lemma for lemma, kind in token.verbs if kind is form]
    for lemma in lemmas:
        if lemma not in _LEFT_TO_CONTROL:
            yield from _framed(chart, chart.word(i, lemma=lemma), form=form, i=i + 1)
    if not token.verbs and form is Form.BASE and _is_unknown_verb(chart, i):
        verb = chart.word(i, known=False)
        yield from _framed(chart, verb, form=form, i=i + 1)


def _is_unknown_verb(chart: Chart, i: int) -> bool:
    """Whether a word that is no known verb stands where only a verb can: "ponder the cube"."""
    token, following = chart.at(i), chart.at(i + 1)
    if token.closed or not token.text[:1].isalpha():
        return False
    j = i + 1 + (following.is_a("particles") or following.text in ("at", "for", "about", "with"))
    return chart.at(j).is_a("determiners") or chart.at(j).text in ("it", "them", "me", "him", "us")


def _framed(chart: Chart, verb: Word, *, form: Form, i: int) -> Found[Predicate]:
    entry = chart.verbs.entry(verb.lemma)
    taking = entry is not None and entry.frame is Frame.TAKE
    before, j = adverbs_at(chart, i + chart.at(i).is_a("pause"))
    j = j if before else i
    changing = frozenset() if entry is None else entry.not_with
    tails = tail_of_taking if taking else tail_of_others
    shifts = entry is not None and entry.frame is not Frame.SHOW
    for particle, start in _particles(chart, j, more=changing):
        more, begin = adverbs_at(chart, start) if particle is not None else ((), start)
        for taken, after in _objects(chart, begin, shifts=shifts):
            for tail, end in tails(chart, after):
                phrase = VerbPhrase(
                    verb=verb, form=form, end=chart.at(end - 1).end, object=taken.object,
                    particle=particle or tail.particle, joined=particle is not None,
                    recipient=taken.recipient, phrases=(*taken.phrases, *tail.phrases),
                    adverbs=(*before, *more, *tail.adverbs),
                )  # fmt: skip
                yield from _gapped(chart, phrase, i=end, taking=taking)
                yield phrase, end


def _particles(chart: Chart, i: int, *, more: frozenset[str]) -> Iterator[tuple[Word | None, int]]:
    token, following = chart.at(i), chart.at(i + 1)
    if (token.text in _BEFORE_OBJECT or token.text in more) and following.text != "of":
        opens = following.is_a("determiners") or following.noun or following.adjective
        unknown = bool(following.text) and not following.known
        if (
            opens
            or unknown
            or (following.is_a("pause") and chart.at(i + 2).is_a("determiners"))
            or following.is_a("adverbs")
            or pronoun_person(chart, i + 1)
            or following.is_a("quantities")
            or following.is_a("cardinals")
        ):
            yield chart.word(i), i + 1
    yield None, i


@dataclass(frozen=True, slots=True, kw_only=True)
class _Taken:
    """What a verb takes; all empty where it stands alone."""

    object: Nominal | None = None
    recipient: NounPhrase | None = None
    phrases: tuple[PrepPhrase, ...] = ()


def _objects(chart: Chart, i: int, *, shifts: bool) -> Found[_Taken]:
    """Yield a recipient and an object, an object, a phrase before an object, or nothing."""
    gives = chart.at(i - 1).verb(Form.BASE) in chart.words.closed["recipient"]
    yield from _with_recipient(chart, i, gives=gives)
    for taken, end in nominal(chart, i):
        if not (end == i + 1 and chart.at(i).is_a("places")):
            yield _Taken(object=taken), end
    if shifts:
        yield from _shifted(chart, i)
    if chart.at(i).is_a("pause") and chart.at(i + 1).is_a("determiners"):
        for taken, end in nominal(chart, i + 1):
            yield _Taken(object=taken), end
    yield _Taken(), i


def _with_recipient(chart: Chart, i: int, *, gives: bool) -> Found[_Taken]:
    """Yield "me the cup"; only what is given goes to an "it"."""
    for recipient, j in simple_noun(chart, i):
        if _may_receive(chart, recipient, gives=gives):
            start = j + (chart.at(j).text == "back")
            for taken, end in () if chart.at(start).is_a("prepositions") else nominal(chart, start):
                if recipient.head.lemma in _BARE_OBJECT or _has_determiner(taken):
                    yield _Taken(object=taken, recipient=recipient), end


def _shifted(chart: Chart, i: int) -> Found[_Taken]:
    """Yield "on the block the cube" of "put on the block the cube"."""
    for phrase, j in single_prep_phrase(chart, i):
        for taken, end in nominal(chart, j):
            if _has_determiner(taken):
                yield _Taken(object=taken, phrases=(phrase,)), end


_BARE_OBJECT: Final = frozenset({"me", "us", "him", "them"})


def _may_receive(chart: Chart, noun: NounPhrase, *, gives: bool) -> bool:
    """Whether somebody is named; what is given may go to anything: "give the duck the bone"."""
    if noun.kind is Kind.PRONOUN:
        return gives or noun.head.lemma != "it"
    name = not noun.head.known and noun.determiner is None and not noun.modifiers
    animate = gives or name or noun.head.lemma in chart.words.animate
    return noun.kind is Kind.NOUN and animate and not noun.after and noun.of is None


def _has_determiner(taken: Nominal) -> bool:
    if isinstance(taken, NounPair):
        return _has_determiner(taken.left)
    return taken.determiner is not None or taken.kind in (Kind.PRONOUN, Kind.DEMONSTRATIVE)


def _gapped(chart: Chart, phrase: VerbPhrase, *, i: int, taking: bool) -> Found[Predicate]:
    """Yield "put the cup on the tray and the fork on the plate": the verb is said once."""
    if phrase.object is None:
        yield from _gapped_look(chart, phrase, i=i)
    if phrase.object is None or not (phrase.phrases or phrase.adverbs):
        return
    paused = chart.at(i).is_a("pause")
    j = i + paused
    start = j + (chart.at(j).text == "and")
    start += chart.at(start).text == "then"
    if start == i or opens_predicate(chart, start):
        return
    for taken, k in nominal(chart, start):
        for tail, end in (tail_of_taking if taking else tail_of_others)(chart, k):
            if not tail.phrases and (not taking or start == j):
                continue
            second = VerbPhrase(
                verb=phrase.verb, form=phrase.form, end=chart.at(end - 1).end, object=taken,
                particle=phrase.particle, joined=phrase.joined, recipient=phrase.recipient,
                phrases=tail.phrases, adverbs=tail.adverbs,
            )  # fmt: skip
            for right, after in (*_gapped(chart, second, i=end, taking=taking), (second, end)):
                word = chart.word(j) if start > j else None
                pair = PredicatePair(conjunction=word, left=phrase, right=right)
                yield pair, after


def _gapped_look(chart: Chart, phrase: VerbPhrase, *, i: int) -> Found[Predicate]:
    """Yield "look at the cup and then at the plate"."""
    entry = chart.verbs.entry(phrase.verb.lemma)
    start = chart.after_pauses(i)
    while chart.at(start).text in ("and", "then"):
        start += 1
    if entry is None or entry.frame is not Frame.SHOW or not phrase.phrases or start == i:
        return
    for found, end in single_prep_phrase(chart, start):
        second = replace(phrase, end=chart.at(end - 1).end, phrases=(found,), adverbs=())
        word = chart.word(start - 1) if chart.at(start - 1).text in ("and", "then") else None
        for right, after in (*_gapped_look(chart, second, i=end), (second, end)):
            yield PredicatePair(conjunction=word, left=phrase, right=right), after
