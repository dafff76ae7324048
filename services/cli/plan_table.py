"""A grounded plan as a table on the terminal."""

from collections.abc import Mapping, Sequence
from typing import Any

from rich.table import Table

_COLOURS = {"grounded": "green", "ambiguous": "yellow", "unknown-symbol": "yellow"}


def plan_table(plan: Mapping[str, Any]) -> Table:
    """Return a row for each instruction; lengths in millimetres where the scale is metric."""
    unit = "mm" if plan.get("scale") == "metric" else "1/1000"
    table = Table(title=f"grounded plan, revision {plan.get('revision', 0)}")
    for column in ("#", "sentence", "action", "target", "location", "status"):
        # What does not fit goes on in the next line; nothing is cut off.
        table.add_column(column, overflow="fold", no_wrap=column in ("action", "status"))
    for column in (f"target at [{unit}]", f"left at [{unit}]", "sure"):
        table.add_column(column, justify="right")
    for each in plan.get("instructions", ()):
        colour = _COLOURS.get(each["status"], "red")
        table.add_row(
            str(each["index"]),
            each["sentence"],
            each["action"],
            " ".join(each["target"]),
            each["location"],
            f"[{colour}]{each['status']}[/{colour}]",
            _millimetres(each["target_position"]),
            _millimetres(each["location_position"]),
            f"{each['confidence']:.2f}",
        )
    return table


def _millimetres(position: Sequence[float] | None) -> str:
    return "" if position is None else " ".join(f"{1000 * x:.0f}" for x in position)
