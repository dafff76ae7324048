"""Noun phrases: determiners, modifiers in any number, heads, complements, coordination."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from grounding.language.grammar.chart import Chart, Found
from grounding.language.grammar.modifiers import (
    is_adverb_as_noun,
    is_nominal,
    modifiers_of,
    nominal_run,
)
from grounding.language.grammar.rules import relative, simple_noun
from grounding.language.grammar.tree import (
    Kind,
    NounModifier,
    NounPhrase,
)
from grounding.language.morphology import Degree, Form
from grounding.language.words import unknown_noun

_PRONOUNS: Final = {
    "it": (3, False), "both": (3, True),
    "them": (3, True), "they": (3, True), "i": (1, False), "me": (1, False),
    "we": (1, True), "us": (1, True), "you": (2, False), "he": (3, False), "him": (3, False),
    "she": (3, False), "her": (3, False), "myself": (1, False), "yourself": (2, False),
    "someone": (3, False), "everyone": (3, False), "something": (3, False),
    "anything": (3, False), "everything": (3, True),
}  # fmt: skip
_WHOLE: Final = frozenset({"all", "both", "half", "either", "neither", "such"})
_COMPARED_BY_PLACE: Final = frozenset({"upper", "lower", "inner", "outer"})
_SHORTER: Final = 3


def pronoun_person(chart: Chart, i: int) -> tuple[int, bool] | None:
    """Return the person of the pronoun at a position and whether it is plural, or None."""
    return _PRONOUNS.get(chart.at(i).text)


@simple_noun.define
def _simple_noun(chart: Chart, i: int) -> Found[NounPhrase]:
    yield from _part(chart, i)
    yield from _described(chart, i)
    yield from _pronoun(chart, i)


def _pronoun(chart: Chart, i: int) -> Found[NounPhrase]:
    person, token = pronoun_person(chart, i), chart.at(i)
    if person is not None:
        end = i + 1 + (chart.at(i + 1).text in ("all", "both"))
        yield _bare(chart, i, kind=Kind.PRONOUN, plural=person[1]), end
    elif token.is_a("demonstratives"):
        plural = token.text in ("these", "those")
        yield _bare(chart, i, kind=Kind.DEMONSTRATIVE, plural=plural), i + 1


def _bare(chart: Chart, i: int, *, kind: Kind, plural: bool) -> NounPhrase:
    word = chart.word(i)
    return NounPhrase(kind=kind, head=word, plural=plural, start=word.start, end=word.end)


def _part(chart: Chart, i: int) -> Found[NounPhrase]:
    """Yield "one of the cubes", "all the cubes", "the bigger of the two cubes"."""
    word, j = chart.at(i), i
    if word.is_a("determiners") and not word.is_a("quantities"):
        j = i + 1
    token = chart.at(j)
    graded = (
        token.degree is not Degree.POSITIVE
        or token.is_a("ordinals")
        or token.text in _COMPARED_BY_PLACE
        or (token.text.endswith("most") and bool(token.adjective))
    )
    if not (token.is_a("quantities") or (graded and j > i)):
        return
    with_of = chart.at(j + 1).text == "of"
    if not with_of and not (token.text in _WHOLE and chart.at(j + 1).is_a("determiners")):
        return
    for whole, end in simple_noun(chart, j + 1 + with_of):
        modifiers = modifiers_of(chart, range(j, j + 1)) if graded else ()
        yield (
            NounPhrase(
                kind=Kind.PART, head=chart.word(j), start=word.start, end=whole.end,
                plural=whole.plural, determiner=chart.word(i) if j > i else None,
                modifiers=modifiers, of=whole,
            ),
            end,
        )  # fmt: skip


def _described(chart: Chart, i: int) -> Found[NounPhrase]:
    """Yield a noun phrase with its determiners, owner and modifiers, the longest first."""
    j = chart.after_phrase(i, name="phrases")
    if j > i and not is_nominal(chart, j, opened=True):
        return
    j = _after_determiners(chart, i)
    determiner = j - 1 if j > i else None
    for core, end in _cores(chart, j, determiner=determiner):
        yield from _with_complements(chart, core, end=end)


def _after_determiners(chart: Chart, i: int) -> int:
    """Return where the determiners end: "all the", "the the" (said twice), but not "a the"."""
    j = i
    while chart.at(j).is_a("determiners") and not _is_name(chart, j):
        before = chart.at(j - 1)
        few = before.text == "a" and chart.at(j).text in ("few", "many")
        if j > i and not (few or before.is_a("quantities") or before.text == chart.at(j).text):
            return j
        j += 1
    return j


def _is_name(chart: Chart, i: int) -> bool:
    """Whether an "A" here is a letter: "block A"."""
    following = chart.at(i + 1)
    described = following.noun or following.adjective or (following.text and not following.known)
    return chart.at(i).text == "a" and chart.at(i).capital and i > 0 and not described


def _cores(chart: Chart, j: int, *, determiner: int | None) -> Found[NounPhrase]:
    run = nominal_run(chart, j, opened=determiner is not None)
    adverbial: list[tuple[NounPhrase, int]] = []
    for last in range(len(run), max(0, len(run) - _SHORTER), -1):
        core = _headed(chart, run[:last], determiner=determiner, first=j)
        if core is not None and _is_adverb_of_place(chart, run[:last]):
            adverbial.append((core, run[last - 1] + 1))
        elif core is not None:
            yield core, run[last - 1] + 1
    yield from adverbial


def _is_adverb_of_place(chart: Chart, run: Sequence[int]) -> bool:
    """Whether a run ends in "left" or "back" behind a noun: "move the block left"."""
    if len(run) < 2:
        return False
    last, before = chart.at(run[-1]), chart.at(run[-2])
    if not (last.is_a("places") or last.is_a("particles")):
        return False
    return not (before.is_a("directions") or before.adjective or before.is_a("ordinals"))


def _headed(
    chart: Chart, run: Sequence[int], *, determiner: int | None, first: int
) -> NounPhrase | None:
    """Return the noun phrase whose head is the last word of a run, or None if it can be none."""
    token, at = chart.at(run[-1]), run[-1]
    kind = _kind(chart, run, determiner=determiner)
    if kind is None:
        return None
    lemma, plural = (token.noun, token.plural) if token.noun else (token.text, False)
    if kind is Kind.NOUN and not token.noun and not token.known:
        lemma, plural = unknown_noun(token.text)
    elif kind is Kind.ADJECTIVE:
        lemma = token.adjective or token.text
    elif kind is Kind.ONE:
        lemma, plural = "one", token.text == "ones"
    start = chart.at(first if determiner is None else determiner).start
    modifiers = modifiers_of(chart, run[:-1])
    if kind is Kind.NUMBER:
        counted = chart.word(run[-2], lemma=chart.at(run[-2]).noun)
        modifiers = (*modifiers_of(chart, run[:-2]), NounModifier(word=counted))
    return NounPhrase(
        kind=kind, head=chart.word(at, lemma=lemma, known=token.known), plural=plural,
        start=start, end=token.end, modifiers=modifiers,
        determiner=None if determiner is None else chart.word(determiner),
    )  # fmt: skip


def _kind(chart: Chart, run: Sequence[int], *, determiner: int | None) -> Kind | None:
    token, before = chart.at(run[-1]), [chart.at(k) for k in run[:-1]]
    after_noun = bool(before) and not before[-1].adjective and not before[-1].is_a("ordinals")
    if token.text in ("one", "ones"):
        alone = not before and determiner is None and token.text == "ones"
        named = after_noun or (before and before[-1].noun and determiner is None)
        return Kind.NUMBER if named else (None if alone else Kind.ONE)
    if token.is_a("cardinals"):
        return Kind.NUMBER if after_noun or (before and before[-1].noun) else None
    if _is_noun(chart, run[-1], opened=determiner is not None or bool(before)):
        return Kind.NOUN
    colour = chart.words.classes.get(token.text) == "colour"
    if token.adjective or token.is_a("ordinals"):
        whole = all(not each.noun or each.adjective for each in before)
        marked = determiner is not None or (colour and not before)
        return Kind.ADJECTIVE if whole and marked else None
    return None


def _is_noun(chart: Chart, i: int, *, opened: bool) -> bool:
    token = chart.at(i)
    if token.noun or not token.known or _is_name(chart, i) or is_adverb_as_noun(chart, i):
        return chart.words.classes.get(token.text) != "colour" or token.noun == "orange"
    return opened and not token.adjective and bool(token.verb(Form.BASE) or token.verb(Form.GERUND))


def _with_complements(chart: Chart, core: NounPhrase, *, end: int) -> Found[NounPhrase]:
    if chart.at(end).text == "'s":
        yield from _owned(chart, core, i=end + 1)
    if chart.at(end).text == "of":
        for of, after in simple_noun(chart, end + 1):
            kind = Kind.PART if core.kind is Kind.ONE else core.kind
            full = _replace(core, kind=kind, of=of, of_word=chart.word(end), end=of.end)
            yield from _with_relatives(chart, full, end=after)
    yield from _with_relatives(chart, core, end=end)


def _owned(chart: Chart, owner: NounPhrase, *, i: int) -> Found[NounPhrase]:
    for core, end in _cores(chart, i, determiner=None):
        owned = _replace(core, owner=owner, start=owner.start)
        yield from _with_complements(chart, owned, end=end)


def _with_relatives(chart: Chart, core: NounPhrase, *, end: int) -> Found[NounPhrase]:
    for attributes, after in relative(chart, end):
        yield _replace(core, after=attributes, end=chart.at(after - 1).end), after
    yield core, end


def _replace(core: NounPhrase, **changes: object) -> NounPhrase:
    return replace(core, **changes)  # type: ignore[arg-type] # names of fields, checked at run time


def opens_predicate(chart: Chart, i: int) -> bool:
    """Whether a verb in its base form with something behind it starts here."""
    token, following = chart.at(i), chart.at(i + 1)
    return bool(token.verb(Form.BASE)) and not (
        following.text in ("", "of") or following.is_a("pause") or following.is_a("conjunctions")
    )
