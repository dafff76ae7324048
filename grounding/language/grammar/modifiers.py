"""What describes a noun: words before it, adjectives and relative clauses behind it."""

from collections.abc import Iterator, Sequence
from typing import Final

from grounding.language.grammar.chart import Chart
from grounding.language.grammar.measures import counts_steps
from grounding.language.grammar.tree import (
    Adjective,
    AdjectivePair,
    Modifier,
    NounModifier,
    Number,
    Word,
)
from grounding.language.morphology import Degree, Form
from grounding.language.words import Token

COLOURING: Final = frozenset({"colored", "coloured", "painted"})
_GRADES: Final = {
    "more": Degree.COMPARATIVE, "less": Degree.COMPARATIVE,
    "most": Degree.SUPERLATIVE, "least": Degree.SUPERLATIVE,
}  # fmt: skip
_INTENSIFIERS: Final = frozenset({"very", "really", "quite", "rather", "extremely", "fairly", "so"})


def nominal_run(chart: Chart, i: int, *, opened: bool) -> list[int]:
    """Return the positions of the words that may form one noun phrase from `i` on.

    Pauses and conjunctions between two adjectives and degree words are skipped over, not listed.

    Args:
        chart: the sentence.
        i: where to start.
        opened: whether a determiner stands before it.
    """
    run: list[int] = []
    j = i
    while True:
        token = chart.at(j)
        measured = bool(run) and chart.at(j).is_a("cardinals") and (
            chart.at(j + 1).is_a("units") or counts_steps(chart, j)
        )  # fmt: skip
        fixed = measured or (bool(run) and chart.after_phrase(j, name="phrases") > j)
        if (
            fixed
            or _describes_from_behind(chart, j, run=run)
            or (run and _opens_phrase(chart, j, before=run[-1]))
            or (run and _runs_on(chart, j, before=run[-1], opened=opened))
        ):
            return run
        if is_nominal(chart, j, opened=opened or bool(run)):
            run.append(j)
        elif not (_links_adjectives(chart, j, run=run) or _grades(chart, j)):
            return run
        j += 1
        if not token.text:
            return run


def _describes_from_behind(chart: Chart, i: int, *, run: Sequence[int]) -> bool:
    """Whether an adjective stands behind the noun it describes: "the box labelled A"."""
    token, following = chart.at(i), chart.at(i + 1)
    if not run or not token.adjective or token.noun or run[-1] != i - 1:
        return False
    before = chart.at(run[-1])
    more = following.noun or following.adjective or (following.text and not following.known)
    return bool(before.noun) and not before.adjective and not more


def _opens_phrase(chart: Chart, i: int, *, before: int) -> bool:
    """Whether a preposition starts here: "next to", "near the", but not "top left of"."""
    if chart.after_phrase(i, name="prepositions") == i:
        following = chart.at(i + 1)
        opens = following.is_a("determiners") or following.is_a("cardinals")
        return chart.at(i).is_a("prepositions") and opens
    last = chart.at(before)
    return not (chart.at(i).is_a("directions") and (last.is_a("directions") or not last.noun))


def _runs_on(chart: Chart, i: int, *, before: int, opened: bool) -> bool:
    """Whether the next command starts here: "take blue block place on red block"."""
    lemma, following = chart.at(i).verb(Form.BASE), chart.at(i + 1)
    if not lemma or chart.verbs.entry(lemma) is None or not chart.at(before).noun:
        return False
    takes_object = following.is_a("determiners") or following.is_a("cardinals")
    takes_object = takes_object or following.text in ("it", "them")
    return takes_object or (not opened and following.is_a("prepositions"))


def is_nominal(chart: Chart, i: int, *, opened: bool) -> bool:
    """Whether a word may be part of a noun phrase."""
    token = chart.at(i)
    if not token.text or token.is_a("junk") or token.is_a("pause"):
        return False
    numeral = token.is_a("ordinals") or token.is_a("cardinals")
    if token.noun or token.adjective or numeral or is_adverb_as_noun(chart, i):
        return True
    if not token.known or token.text in ("one", "ones"):
        following = chart.at(i + 1)
        manner = token.text.endswith("ly") and len(token.text) > 4
        return not manner or (opened and bool(following.noun or _is_new(following)))
    if not opened and token.verb(Form.GERUND) and chart.at(i - 1).is_a("prepositions"):
        return bool(chart.at(i + 1).noun)
    if not opened or token.closed:
        return token.text == "a" and token.capital and i > 0
    return _is_verbal(chart, i)


def is_adverb_as_noun(chart: Chart, i: int) -> bool:
    """Whether an adverb is a noun here, right behind a determiner: "to the well"."""
    token, following = chart.at(i), chart.at(i + 1)
    adverbial = token.is_a("adverbs") or token.is_a("interjections")
    opened = chart.at(i - 1).is_a("determiners") and not token.is_a("determiners")
    more = following.noun or following.adjective or _is_new(following)
    return bool(adverbial and opened and not more and not _is_ordered(token, following))


def _is_ordered(token: Token, following: Token) -> bool:
    """Whether a word counts or compares: "the first of them", "the next one"."""
    return token.is_a("ordinals") or following.text in ("one", "ones", "of")


def _is_new(token: Token) -> bool:
    """Whether a word is unknown, and no adverb."""
    return bool(token.text) and not token.known and not token.text.endswith("ly")


def _is_verbal(chart: Chart, i: int) -> bool:
    """Whether a verb may stand in a noun phrase: "the lift", "the cutting board"."""
    token, before = chart.at(i), chart.at(i - 1)
    if token.verb(Form.GERUND) and before.is_a("determiners"):
        return True
    if token.verb(Form.GERUND) or token.verb(Form.PARTICIPLE):
        following = chart.at(i + 1)
        return bool(following.noun or not following.known) and not before.noun
    lead = before.is_a("determiners") or (before.adjective and not before.noun)
    return bool(lead and token.verb(Form.BASE))


def is_adjective(token: Token) -> bool:
    """Whether a word may be an adjective; an unknown word may."""
    return bool(token.adjective) or (not token.known and not token.text.endswith("ly"))


def _links_adjectives(chart: Chart, j: int, *, run: Sequence[int]) -> bool:
    token = chart.at(j)
    if not run or run[-1] != j - 1 or token.text not in (",", "-", "and", "or"):
        return token.text == "and" and chart.at(j - 1).text == "," and bool(run)
    following = j + 1 + (chart.at(j + 1).text == "and")
    if not (chart.at(j - 1).adjective and chart.at(following).adjective):
        return False
    after = chart.at(following + 1)
    return bool(after.noun or after.adjective or after.text in ("one", "ones", ",", "and")
                or (after.text and not after.known))  # fmt: skip


def _grades(chart: Chart, j: int) -> bool:
    """Whether a degree word stands before an adjective: "most", "very", "slightly"."""
    token = chart.at(j)
    if not is_adjective(chart.at(j + 1)):
        more = token.text == "more" and chart.at(j - 1).is_a("cardinals")
        return more or (token.text == "very" and bool(chart.at(j + 1).noun))
    return token.text in _GRADES or token.text in _INTENSIFIERS or _is_manner(token)


def _is_manner(token: Token) -> bool:
    return token.text.endswith("ly") and (not token.known or token.is_a("adverbs"))


def modifiers_of(chart: Chart, run: Sequence[int]) -> tuple[Modifier, ...]:
    """Return the words of a run as modifiers, adjectives with a conjunction between them paired."""
    found: list[Modifier] = []
    for k in run:
        modifier = _modifier(chart, k)
        if found and _is_listed(chart, k, run=run):
            pair = AdjectivePair(conjunction=chart.word(k - 1), left=found.pop(), right=modifier)
            found.append(pair)
        elif chart.at(k).text in COLOURING and chart.words.classes.get(chart.at(k - 1).text):
            continue
        else:
            found.append(modifier)
    return tuple(found)


def _is_listed(chart: Chart, k: int, *, run: Sequence[int]) -> bool:
    """Whether an adjective stands in a list that has a conjunction: "red, blue and green"."""
    if k - 1 in run or chart.at(k - 1).text not in (",", "and", "or"):
        return False
    last = k - 1
    while chart.at(last).text == "," and last + 1 in run and last + 2 not in run:
        last += 2
    return chart.at(last).text in ("and", "or")


def _modifier(chart: Chart, k: int) -> Modifier:
    token = chart.at(k)
    if token.is_a("ordinals"):
        return Number(word=chart.word(k), value=token.text, ordinal=True)
    if token.is_a("cardinals"):
        return Number(word=chart.word(k), value=token.text, ordinal=False)
    if token.noun and not token.adjective:
        return NounModifier(word=chart.word(k, lemma=token.noun))
    return adjective_at(chart, k)


def adjective_at(chart: Chart, k: int) -> Adjective:
    """Return the adjective at a position with the degree word before it."""
    token, before = chart.at(k), chart.at(k - 1)
    degree = _GRADES.get(before.text, token.degree)
    intensifier: Word | None = None
    if before.text in _INTENSIFIERS or (k and _is_manner(before)):
        intensifier = chart.word(k - 1)
    lemma = token.adjective or token.text
    word = chart.word(k, lemma=lemma, known=token.known)
    return Adjective(word=word, degree=degree, intensifier=intensifier)


def adjectives(found: Adjective | AdjectivePair) -> Iterator[Adjective]:
    """Yield each adjective of a possibly paired one."""
    if isinstance(found, Adjective):
        yield found
        return
    for side in (found.left, found.right):
        if isinstance(side, (Adjective, AdjectivePair)):
            yield from adjectives(side)
