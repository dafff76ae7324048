"""Adverbs, markers of discourse and polite words: what an instruction can do without."""

from grounding.language.grammar.chart import Chart
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
    end = chart.after_phrase(j, name="phrases")
    if end > j:
        return Adverb(word=chart.joined(j, end)), end
    without = chart.after_phrase(j, name="without")
    if without > j and closing:
        return _without(chart, j, i=without)
    if closing and _measure(chart, j) > j:
        return Adverb(word=chart.joined(j, _measure(chart, j))), _measure(chart, j)
    if _is_adverb(chart, j, closing=closing):
        return Adverb(word=chart.word(j)), j + 1
    return None, i


def _is_adverb(chart: Chart, i: int, *, closing: bool) -> bool:
    token, following = chart.at(i), chart.at(i + 1)
    if chart.after_phrase(i, name="prepositions") > i:
        return False
    if token.is_a("calls") and following.is_a("pause") and not closing:
        return True
    opens_next = closing and token.text == "then" and bool(following.text)
    acts = bool(token.verb(Form.BASE)) and not token.is_a("interjections")
    if closing and token.is_a("results"):
        return True
    if acts or opens_next:
        return False
    if token.is_a("adverbs") or token.is_a("interjections"):
        return True
    return token.text.endswith("ly") and len(token.text) > 4 and not token.known


def _measure(chart: Chart, i: int) -> int:
    """Return where "two inches" or "by ninety degrees" ends, or `i`."""
    j = i + (chart.at(i).text in ("by", "for", "about"))
    k = j + (chart.at(j).is_a("cardinals") or chart.at(j).text in ("a", "an", "one", "few"))
    k += chart.at(k).text in ("few", "little", "bit")
    return k + 1 if k > j and chart.at(k).is_a("units") else i


def _without(chart: Chart, j: int, *, i: int) -> tuple[Adverb | None, int]:
    """Return "instead of the red one" or "without touching it" as one adverb."""
    for _, end in (*gerund_predicate(chart, i), *simple_noun(chart, i)):
        return Adverb(word=chart.joined(j, end)), end
    return None, j
