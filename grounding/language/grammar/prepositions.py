"""Prepositional phrases and adverbs of place."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from grounding.language.grammar.chart import Chart, Found, Rule
from grounding.language.grammar.rules import (
    nominal,
    prep_phrase,
    simple_noun,
    single_prep_phrase,
)
from grounding.language.grammar.tree import (
    Kind,
    Nominal,
    NounPair,
    NounPhrase,
    PrepPhrase,
    Word,
)
from grounding.language.morphology import Form

_NO_PHRASE: Final = frozenset({"of", "than"})
_SUBJECTS: Final = frozenset({"i", "you", "we", "he", "she", "they", "it"})
_TAKES_PHRASE: Final = frozenset({"from", "in", "over", "up", "down", "to", "out+from"})


@prep_phrase.define
def _prep_phrase(chart: Chart, i: int) -> Found[PrepPhrase]:
    yield from _phrase(chart, i, landmark=nominal)


@single_prep_phrase.define
def _single_prep_phrase(chart: Chart, i: int) -> Found[PrepPhrase]:
    yield from _phrase(chart, i, landmark=simple_noun)


def _phrase(
    chart: Chart, i: int, *, landmark: Rule[Nominal] | Rule[NounPhrase]
) -> Found[PrepPhrase]:
    i += chart.at(i).text == "but" and _opens(chart, i + 1)
    negation = chart.word(i) if chart.at(i).text == "not" else None
    j = _sharpened(chart, i + (negation is not None))
    for word, end in _prepositions(chart, j):
        for phrase, after in _completed(chart, word, end=end, landmark=landmark):
            yield _denied(phrase, by=negation), after
    if chart.at(j).is_a("places") and chart.at(j + 1).text != "of":
        yield PrepPhrase(word=chart.word(j), negation=negation), j + 1


def _denied(phrase: PrepPhrase, *, by: Word | None) -> PrepPhrase:
    if by is None:
        return phrase
    return PrepPhrase(word=phrase.word, landmark=phrase.landmark, inner=phrase.inner, negation=by)


def _sharpened(chart: Chart, i: int) -> int:
    """Skip "right", "directly" or "back" that only sharpen the preposition that follows."""
    token = chart.at(i)
    if chart.after_phrase(i, name="prepositions") > i and not token.is_a("dropped"):
        return i
    if token.is_a("sharpeners") and _opens(chart, i + 1):
        return _sharpened(chart, i + 1)
    kept = chart.after_phrase(i, name="kept") > i
    following = i + 1 + (chart.at(i + 1).text == "and")
    if token.is_a("dropped") and not kept and _opens(chart, following, places=False):
        return following
    return i


def _opens(chart: Chart, i: int, *, places: bool = True) -> bool:
    """Whether a prepositional phrase, or an adverb of place, may start here."""
    token = chart.at(i)
    if token.is_a("sharpeners") and _opens(chart, i + 1, places=places):
        return True
    if chart.after_phrase(i, name="prepositions") > i:
        return True
    if token.is_a("prepositions"):
        return token.text not in _NO_PHRASE
    return places and token.is_a("places")


def _prepositions(chart: Chart, i: int) -> Iterator[tuple[Word, int]]:
    """Yield the preposition at a position; two may share a landmark: "left and below"."""
    for word, end in _single_prepositions(chart, i):
        yield word, end
    j = i + 1
    if (chart.at(i).is_a("places") or chart.at(i).is_a("prepositions")) and (
        chart.at(j).text == "and"
    ):
        for _, end in _single_prepositions(chart, j + 1):
            yield chart.joined(i, end), end


def _single_prepositions(chart: Chart, i: int) -> Iterator[tuple[Word, int]]:
    end = chart.after_phrase(i, name="prepositions")
    if end > i:
        yield chart.joined(i, end), end
    token = chart.at(i)
    there = token.text in ("up", "down") and chart.at(i + 1).text in ("there", "here")
    if there or (token.is_a("prepositions") and token.text not in _NO_PHRASE):
        yield chart.word(i), i + 1


def _completed(
    chart: Chart, word: Word, *, end: int, landmark: Rule[Nominal] | Rule[NounPhrase]
) -> Found[PrepPhrase]:
    if word.lemma.endswith("between"):
        yield from _between(chart, word, end=end)
    if word.lemma in _TAKES_PHRASE:
        for inner, after in _inner(chart, end, word=word, landmark=landmark):
            yield PrepPhrase(word=word, inner=inner), after
    if not (word.lemma == "to" and _is_infinitive(chart, end)):
        yield from _number(chart, word, i=end)
        yield from _with_landmark(chart, word, end=end, landmark=landmark)


def _with_landmark(
    chart: Chart, word: Word, *, end: int, landmark: Rule[Nominal] | Rule[NounPhrase]
) -> Found[PrepPhrase]:
    for found, after in landmark(chart, end):
        if isinstance(found, NounPair) and not _is_list(found):
            continue
        if not (chart.at(end).text in _SUBJECTS and chart.at(after).verbs):
            yield PrepPhrase(word=word, landmark=found), after


def _number(chart: Chart, word: Word, *, i: int) -> Found[PrepPhrase]:
    """Yield the "to three" of a dial."""
    token, following = chart.at(i), chart.at(i + 1)
    ends = not following.text or following.is_a("pause") or following.is_a("conjunctions")
    if ends and token.is_a("cardinals") and word.lemma in ("to", "from"):
        mark = NounPhrase(kind=Kind.NUMBER, head=chart.word(i), start=token.start, end=token.end)
        yield PrepPhrase(word=word, landmark=mark), i + 1


def _is_list(pair: NounPair) -> bool:
    """Whether landmarks have a conjunction before the last: "to the left, the cube" is no list."""
    if pair.conjunction is not None:
        return True
    return isinstance(pair.right, NounPair) and _is_list(pair.right)


def _is_infinitive(chart: Chart, i: int) -> bool:
    token, following = chart.at(i), chart.at(i + 1)
    opens = following.is_a("determiners") or following.text in ("it", "them")
    return bool(token.verb(Form.BASE)) and opens


def _between(chart: Chart, word: Word, *, end: int) -> Found[PrepPhrase]:
    """Yield "between X and Y" with exactly two landmarks before anything else is tried."""
    for left, j in (*simple_noun(chart, end), *_placed(chart, end)):
        if chart.at(j).text not in ("and", "&"):
            continue
        placed = any(isinstance(each, PrepPhrase) for each in left.after)
        second = (*_placed(chart, j + 1),) if placed else ()
        for right, after in (*second, *simple_noun(chart, j + 1)):
            pair = NounPair(
                conjunction=chart.word(j), left=left, right=right, start=left.start, end=right.end
            )
            yield PrepPhrase(word=word, landmark=pair), after


def _placed(chart: Chart, i: int) -> Found[NounPhrase]:
    """Yield "the fork on the left": a landmark that says where it is."""
    for noun, j in simple_noun(chart, i):
        for phrase, end in single_prep_phrase(chart, j):
            yield replace(noun, after=(*noun.after, phrase), end=chart.at(end - 1).end), end


def _inner(
    chart: Chart, i: int, *, word: Word, landmark: Rule[Nominal] | Rule[NounPhrase]
) -> Found[PrepPhrase]:
    """Yield the phrase that a preposition takes: "from under the table", "over there"."""
    token = chart.at(i)
    if token.is_a("places") and not token.noun:
        yield PrepPhrase(word=chart.word(i)), i + 1
    if word.lemma in ("from", "out+from") and not token.noun:
        for inner, end in _prepositions(chart, i):
            for found, after in landmark(chart, end):
                yield PrepPhrase(word=inner, landmark=found), after
