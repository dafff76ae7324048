"""Adverbs, markers of discourse and polite words: what an instruction can do without."""

from grounding.language.grammar.chart import Chart
from grounding.language.grammar.measures import after_measure
from grounding.language.grammar.rules import gerund_predicate, simple_noun
from grounding.language.grammar.tree import Adverb
from grounding.language.morphology import Form


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
    j = i + (closing and chart.at(i).is_a("pause"))
    said = chart.after_phrase(j, name="phrases")
    for end in (said, _after_aside(chart, i), after_measure(chart, j) if closing else j):
        if end > j:
            return Adverb(word=chart.joined(j, end)), end
    without = chart.after_phrase(j, name="without")
    if without > j:
        return _without(chart, j, i=without)
    if closing and chart.at(j).text == "where":
        return _where(chart, j)
    if _is_adverb(chart, j, closing=closing):
        return Adverb(word=chart.word(j)), j + 1
    return None, i


def _after_aside(chart: Chart, i: int) -> int:
    """Return where "you know" between pauses, or ", would you" at the end, ends; else `i`."""
    j = chart.after_pauses(i)
    paused = j > i or i == 0 or chart.at(i - 1).is_a("pause")
    end = chart.after_phrase(j, name="asides")
    if paused and end > j and (chart.at(end).is_a("pause") or not chart.at(end).text):
        return end
    end = chart.after_phrase(j, name="tags")
    return end if end > j > 0 and not chart.at(end).text else i


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


def _without(chart: Chart, j: int, *, i: int) -> tuple[Adverb | None, int]:
    """Return "instead of the red one" or "without touching it" as one adverb."""
    for _, end in (*gerund_predicate(chart, i), *simple_noun(chart, i)):
        return Adverb(word=chart.joined(j, end)), end
    return None, j
