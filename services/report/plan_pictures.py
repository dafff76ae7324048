"""The plan over time: what was said, what was inferred, where the person looked."""

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.figure import Figure

from gazemap.types.fixation import Fixation3D
from services.rebuild.outputs import Membership
from services.report.picture import instruction_colour

_STATUS_MARKS = {"grounded": "", "ambiguous": " (ambiguous)", "ungrounded": " (ungrounded)"}


def timeline_figure(
    instructions: Sequence[Mapping[str, Any]],
    fixations: Sequence[Fixation3D],
    memberships: Mapping[int, Membership],
) -> Figure:
    """Return a row for each instruction with its inferred segment, and the fixations below."""
    height = 1.6 + 0.34 * (len(instructions) + 1)
    figure = Figure(figsize=(13, height), layout="constrained")
    axes = figure.add_subplot()
    start_ns = min((each.fixation.start_ns for each in fixations), default=0)
    for row, each in enumerate(instructions):
        colour = instruction_colour(int(each["index"]))
        if each["start_ns"] is not None and each["end_ns"] is not None:
            begin = (each["start_ns"] - start_ns) / 1e9
            axes.barh(row, (each["end_ns"] - each["start_ns"]) / 1e9, left=begin, color=colour)
    for fixation in fixations:
        member = memberships.get(fixation.fixation.fixation_id)
        colour = instruction_colour(None if member is None else member.instruction)
        begin = (fixation.fixation.start_ns - start_ns) / 1e9
        length = (fixation.fixation.end_ns - fixation.fixation.start_ns) / 1e9
        axes.barh(len(instructions), length, left=begin, color=colour, edgecolor="white")
    labels = [_label(each) for each in instructions]
    axes.set_yticks(range(len(labels) + 1), [*labels, "fixations"])
    axes.invert_yaxis()
    axes.set_xlabel("time [s]")
    axes.grid(axis="x", alpha=0.3)
    return figure


def _label(each: Mapping[str, Any]) -> str:
    mark = _STATUS_MARKS.get(each["status"], f" ({each['status']})")
    return f"{each['index']}  {each['action']} {' '.join(each['target'])}{mark}"
