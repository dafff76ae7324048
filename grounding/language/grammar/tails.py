"""What follows the object of a verb: phrases, adverbs and a particle, in any order."""

from dataclasses import dataclass, replace

from grounding.language.grammar.adverbs import adverb_at
from grounding.language.grammar.chart import Chart, Found, Rule
from grounding.language.grammar.rules import (
    nominal,
    prep_phrase,
    simple_noun,
    single_prep_phrase,
)
from grounding.language.grammar.tree import Adverb, NounPair, PrepPhrase, Word


@dataclass(frozen=True, slots=True, kw_only=True)
class Tail:
    """What follows the object of a verb, in order; one that restarts takes back what was before."""

    phrases: tuple[PrepPhrase, ...] = ()
    adverbs: tuple[Adverb, ...] = ()
    particle: Word | None = None
    restarts: bool = False


tail_of_taking = Rule[Tail]("tail of a verb of taking")
tail_of_others = Rule[Tail]("tail of any other verb")


@tail_of_taking.define
def _tail_of_taking(chart: Chart, i: int) -> Found[Tail]:
    yield from _tail(chart, i, rest=tail_of_taking, phrases=single_prep_phrase(chart, i))


@tail_of_others.define
def _tail_of_others(chart: Chart, i: int) -> Found[Tail]:
    found = (*prep_phrase(chart, i), *_along(chart, i))
    paired = [each for each in found if _starves(chart, each)]
    ordered = (*(each for each in found if each not in paired), *paired)
    yield from _tail(chart, i, rest=tail_of_others, phrases=ordered)


def _along(chart: Chart, i: int) -> Found[PrepPhrase]:
    """Yield "down the ramp": only behind an object are "up" and "down" prepositions."""
    if chart.at(i).text in ("up", "down") and chart.at(i + 1).is_a("determiners"):
        for landmark, end in simple_noun(chart, i + 1):
            yield PrepPhrase(word=chart.word(i), landmark=landmark), end


def _starves(chart: Chart, found: tuple[PrepPhrase, int]) -> bool:
    """Whether a landmark with a conjunction takes what another phrase follows."""
    phrase, end = found
    if not isinstance(phrase.landmark, NounPair) or phrase.word.lemma.endswith("between"):
        return False
    start = end + (chart.at(end).text == "and")
    more = nominal(chart, start) if start > end else ()
    return any(prep_phrase(chart, after) for after in (end, *(after for _, after in more)))


def _tail(
    chart: Chart, i: int, *, rest: Rule[Tail], phrases: tuple[tuple[PrepPhrase, int], ...]
) -> Found[Tail]:
    for piece, j in _pieces(chart, i, phrases=phrases):
        yield from _followed(chart, piece, i=j, rest=rest)
        for second, k in _and_phrase(chart, j) if piece.phrases else ():
            yield from _followed(chart, _joined(piece, second), i=k, rest=rest)
    yield Tail(), i
    corrected = chart.after_correction(i)
    for phrase, j in single_prep_phrase(chart, corrected) if corrected > i else ():
        for tail, end in rest(chart, j):
            yield replace(_joined(Tail(phrases=(phrase,)), tail), restarts=True), end
    for phrase, j in single_prep_phrase(chart, i + 1) if chart.at(i).is_a("pause") else ():
        yield from _followed(chart, Tail(phrases=(phrase,)), i=j, rest=rest)


def _followed(chart: Chart, piece: Tail, *, i: int, rest: Rule[Tail]) -> Found[Tail]:
    for tail, end in rest(chart, i):
        yield _joined(piece, tail), end


def _and_phrase(chart: Chart, i: int) -> Found[Tail]:
    """Yield "and next to the bowl", which shares the place of the phrase before."""
    if chart.at(i).text in ("and", "or"):
        for phrase, end in single_prep_phrase(chart, i + 1):
            yield Tail(phrases=(replace(phrase, joined=chart.word(i)),)), end


def _pieces(chart: Chart, i: int, *, phrases: tuple[tuple[PrepPhrase, int], ...]) -> Found[Tail]:
    """Yield one piece of a tail: a phrase, an adverb or a particle."""
    adverb, after = adverb_at(chart, i, closing=True)
    if adverb is None or after == i + 1:
        for phrase, j in phrases:
            yield Tail(phrases=(phrase,)), j
    if adverb is not None:
        yield Tail(adverbs=(adverb,)), after
    if chart.at(i).is_a("particles"):
        yield Tail(particle=chart.word(i)), i + 1


def _joined(first: Tail, then: Tail) -> Tail:
    kept = () if then.restarts else first.phrases
    return Tail(
        phrases=(*kept, *then.phrases), adverbs=(*first.adverbs, *then.adverbs),
        particle=first.particle or then.particle, restarts=then.restarts,
    )  # fmt: skip
