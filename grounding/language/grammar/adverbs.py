"""Adverbs, markers of discourse and polite words: what an instruction can do without."""

from grounding.language.grammar.chart import Chart, Found, Rule
from grounding.language.grammar.measures import after_measure
from grounding.language.grammar.rules import gerund_predicate, simple_noun, single_base
from grounding.language.grammar.tree import Adverb
from grounding.language.morphology import Form

_opening_adverb = Rule[Adverb | None]("an adverb before a verb")
_closing_adverb = Rule[Adverb | None]("an adverb behind a verb")


def adverbs_at(chart: Chart, i: int) -> tuple[tuple[Adverb, ...], int]:
    """Return the adverbs that start at a position, with the pauses among them, and their end."""
    found: list[Adverb] = []
    while True:
        adverb, end = adverb_at(chart, i, closing=False)
        if adverb is not None:
            found.append(adverb)
            i = end
        elif found and chart.at(i).is_a("pause"):
            i += 1
        else:
            return tuple(found), i


def adverb_at(chart: Chart, i: int, *, closing: bool) -> tuple[Adverb | None, int]:
    """Return the adverb at a position and its end; (None, i) where there is none.

    Args:
        chart: the sentence.
        i: where to look.
        closing: whether the place is behind a verb, where "open" and ", please" may stand.
    """
    return (_closing_adverb if closing else _opening_adverb)(chart, i)[0]


@_opening_adverb.define
def _opens(chart: Chart, i: int) -> Found[Adverb | None]:
    yield _adverb(chart, i, closing=False)


@_closing_adverb.define
def _closes(chart: Chart, i: int) -> Found[Adverb | None]:
    yield _adverb(chart, i, closing=True)


def _adverb(chart: Chart, i: int, *, closing: bool) -> tuple[Adverb | None, int]:
    j = i + (closing and chart.at(i).is_a("pause"))
    said = chart.after_phrase(j, name="phrases")
    measured = after_measure(chart, j) if closing else j
    for end in (said, _after_aside(chart, i), measured, _after_reciprocal(chart, j)):
        if end > j:
            return Adverb(word=chart.joined(j, end)), end
    without = chart.after_phrase(j, name="without")
    if without > j:
        return _without(chart, j, i=without)
    if closing and chart.at(j).text == "where":
        return _where(chart, j)
    if closing and chart.at(j).text == "to":
        return _purpose(chart, j)
    if _is_adverb(chart, j, closing=closing):
        return Adverb(word=chart.word(j)), j + 1
    return None, i


def _after_aside(chart: Chart, i: int) -> int:
    """Return where "you know" between pauses, or ", would you" at the end, ends; else `i`."""
    j = chart.after_pauses(i)
    paused = j > i or i == 0 or chart.at(i - 1).is_a("pause")
    end = chart.after_phrase(j, name="asides")
    following = chart.at(end)
    if paused and end > j and (following.is_a("pause") or not following.text):
        return end
    if j == i > 0 and end > j + 1 and following.is_a("prepositions"):
        return end
    if end > j and following.text in ("i", "you", "we") and chart.at(j).text == "i":
        return end
    end = chart.after_phrase(j, name="tags")
    return end if end > j > 0 and not chart.at(end).text else i


def _after_reciprocal(chart: Chart, i: int) -> int:
    """Return where "on top of each other" ends, which says no place, or `i`."""
    end = chart.after_phrase(i, name="prepositions") if i else i
    end += end == i and chart.at(i).is_a("prepositions")
    words = (chart.at(end).text, chart.at(end + 1).text)
    return end + 2 if end > i and words in (("each", "other"), ("one", "another")) else i


def _is_adverb(chart: Chart, i: int, *, closing: bool) -> bool:
    token, following = chart.at(i), chart.at(i + 1)
    paused = not following.text or following.is_a("pause")
    if closing and token.is_a("results"):
        return True
    if token.is_a("calls") and paused and not closing:
        return bool(following.text)
    if _has_another_use(chart, i, closing=closing):
        return False
    listed = token.is_a("adverbs") or token.is_a("interjections")
    return listed or (token.text.endswith("ly") and len(token.text) > 4 and not token.known)


def _has_another_use(chart: Chart, i: int, *, closing: bool) -> bool:
    """Whether a word opens a phrase ("next to"), is a verb or determiner, or goes with the next."""
    token, following = chart.at(i), chart.at(i + 1)
    if chart.after_phrase(i, name="prepositions") > i:
        return True
    if token.verb(Form.BASE) and not token.is_a("interjections"):
        return True
    if token.is_a("directions") and following.is_a("determiners"):
        return True
    if token.is_a("determiners"):
        return not (following.is_a("pause") or following.verb(Form.BASE) or not following.text)
    return closing and token.text == "then" and bool(following.text)


def _where(chart: Chart, i: int) -> tuple[Adverb | None, int]:
    """Return "where it was" or "where you found it" as one adverb."""
    for _, j in simple_noun(chart, i + 1):
        if chart.at(j).verbs:
            end = j + 1 + (chart.at(j + 1).text in ("it", "them"))
            return Adverb(word=chart.joined(i, end)), end
    return None, i


def _purpose(chart: Chart, i: int) -> tuple[Adverb | None, int]:
    """Return "to close it" as one adverb: what a deed is good for is no command."""
    before, opens = chart.at(i - 1), chart.at(i + 2)
    if before.verbs and not before.noun:
        return None, i
    if opens.is_a("determiners") or opens.is_a("particles") or opens.text in ("it", "them"):
        for _, end in single_base(chart, i + 1):
            return Adverb(word=chart.joined(i, end)), end
    return None, i


def _without(chart: Chart, j: int, *, i: int) -> tuple[Adverb | None, int]:
    """Return "instead of the red one" or "without touching it" as one adverb."""
    for _, end in (*gerund_predicate(chart, i), *simple_noun(chart, i)):
        return Adverb(word=chart.joined(j, end)), end
    return None, j
