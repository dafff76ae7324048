"""A picture of each symbol: its group's distributions, and the patches kept and dropped."""

import io

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from grounding.errors import InputError
from grounding.features.registry import FEATURES
from grounding.symbols.model import Group, SymbolModel
from grounding.types import FloatArray

_PANELS = 6
_LETTER, _LINE = 0.018, 0.1  # of a panel's width and of a curve's height
_EXAMPLE_COLOUR, _STRAY_COLOUR = "tab:green", "tab:red"


def draw_symbol(model: SymbolModel, word: str) -> bytes:
    """Return a PNG: one panel for each of the features that tell the word best.

    Raises:
        InputError: if the word is not known.
    """
    group = model.group_of(word)
    if group is None:
        known = ", ".join(sorted(model.words))
        raise InputError(f"no word {word!r}", where="model", todo=f"name one of: {known}")
    features = telling_features(model, group, word)
    figure = Figure(figsize=(10, 2.6 * max(1, -(-len(features) // 3))), layout="constrained")
    FigureCanvasAgg(figure)
    known_word = model.words[word]
    figure.suptitle(
        f"{word}   group: {group.name}{'' if group.is_sure else ' (unsure)'}   "
        f"patches: {known_word.kept} kept, {known_word.dropped} dropped"
    )
    handles = [
        Line2D([], [], color="black", lw=2, label=word),
        Line2D([], [], color="0.6", label="other words of the group"),
        Line2D([], [], color=_EXAMPLE_COLOUR, marker="|", ls="", label="kept patches"),
        Line2D([], [], color=_STRAY_COLOUR, marker="|", ls="", label="dropped patches"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=8, frameon=False)
    for number, feature in enumerate(features):
        axes = figure.add_subplot(-(-len(features) // 3), 3, number + 1)
        _draw_panel(axes, model, group, word, feature)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=80)
    return buffer.getvalue()


def telling_features(model: SymbolModel, group: Group, word: str) -> tuple[str, ...]:
    """Return the group's features that set a word apart best, the best first."""
    columns = model.columns(group.features)
    own = model.words[word].moments
    everything = model.anything
    inside = np.diag(own.scatter)[columns] / max(own.weight, 1.0)
    overall = np.diag(everything.scatter)[columns] / max(everything.weight, 1.0)
    contrast = (overall + 1) / (inside + 1)
    order = np.argsort(-contrast, kind="stable")[:_PANELS]
    return tuple(group.features[place] for place in order)


def _draw_panel(axes: Axes, model: SymbolModel, group: Group, word: str, feature: str) -> None:
    """Draw one feature: a curve for each word of the group, ticks for the word's patches."""
    column = model.columns((feature,))[0]
    scale, offset = model.unit[column], model.offset[column]
    named: list[tuple[float, str]] = []
    for each in group.words:
        moments = model.words[each].moments
        if moments.weight <= 0:
            continue
        centre = moments.mean[column] * scale + offset
        sigma = max(np.sqrt(moments.scatter[column, column] / moments.weight), 0.1) * scale
        x = np.linspace(centre - 4 * sigma, centre + 4 * sigma, 81)
        y = np.exp(-(((x - centre) / sigma) ** 2) / 2)
        axes.plot(x, y, color="black" if each == word else "0.6", lw=2 if each == word else 1)
        named.append((float(centre), each))
    _write_names(axes, sorted(named), own=word)
    known = model.words[word]
    for samples, height, colour in (
        (known.examples, -0.08, _EXAMPLE_COLOUR),
        (known.strays, -0.2, _STRAY_COLOUR),
    ):
        if len(samples):
            _draw_ticks(axes, samples[:, column] * scale + offset, height, colour)
    axes.set_xlabel(f"{feature} [{FEATURES[feature].unit}]", fontsize=8)
    axes.set_yticks([])
    axes.tick_params(labelsize=7)


def _write_names(axes: Axes, named: list[tuple[float, str]], *, own: str) -> None:
    """Write words (centre, word) over their curves, a line higher where they would overlap."""
    low, high = axes.get_xlim()
    free_from: list[float] = []  # where each line is free again
    for centre, word in named:
        width = (high - low) * _LETTER * (len(word) + 2)
        line = next((n for n, end in enumerate(free_from) if centre - width / 2 > end), None)
        if line is None:
            line = len(free_from)
            free_from.append(low)
        free_from[line] = centre + width / 2
        weight = "bold" if word == own else "normal"
        place = (centre, 1.03 + _LINE * line)
        axes.annotate(word, place, ha="center", fontsize=7, fontweight=weight)
    axes.set_ylim(-0.3, 1.12 + _LINE * max(1, len(free_from)))


def _draw_ticks(axes: Axes, values: FloatArray, height: float, colour: str) -> None:
    axes.plot(values, np.full(len(values), height), "|", color=colour, ms=7)
