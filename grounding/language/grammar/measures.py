"""How far and how much: counts of units and of steps."""

from grounding.language.grammar.chart import Chart


def after_measure(chart: Chart, i: int) -> int:
    """Return where "two inches", "by ninety degrees" or the "two squares" before a way ends."""
    j = i + (chart.at(i).text in ("by", "for", "about"))
    k = _after_amount(chart, j)
    if k > j and chart.at(k).is_a("units"):
        return k + 1
    return k + 1 if counts_steps(chart, j) else i


def _after_amount(chart: Chart, i: int) -> int:
    """Return where "a few", "half a" or "one hundred and eighty" ends, or `i`."""
    k = i
    while chart.at(k).is_a("cardinals") or (
        k > i and chart.at(k).text == "and" and chart.at(k + 1).is_a("cardinals")
    ):
        k += 1
    k += chart.at(k).text in ("half", "quarter")
    k += chart.at(k).text in ("a", "an", "few")
    while k > i and chart.at(k).text in ("few", "little", "bit", "half", "quarter", "full", "more"):
        k += 1
    return k


def counts_steps(chart: Chart, i: int) -> bool:
    """Whether a count of things says how far: "two squares forward", "one row to the left"."""
    if not chart.at(i).is_a("cardinals") or not chart.at(i + 1).noun:
        return False
    following = chart.at(i + 2)
    if (following.text, chart.at(i + 3).text) == ("to", "the"):
        return chart.at(i + 4).is_a("directions")
    return (following.is_a("places") or following.is_a("particles")) and not following.is_a(
        "prepositions"
    )
