"""A picture of each symbol: its group's distributions, and the patches kept and dropped."""

import io

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from grounding.errors import InputError
from grounding.features.registry import FEATURES
from grounding.symbols.model import Group, SymbolModel
from grounding.types import FloatArray

_PANELS = 6
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
    for each in group.words:
        moments = model.words[each].moments
        if moments.weight <= 0:
            continue
        centre = moments.mean[column] * scale + offset
        sigma = max(np.sqrt(moments.scatter[column, column] / moments.weight), 0.1) * scale
        x = np.linspace(centre - 4 * sigma, centre + 4 * sigma, 81)
        y = np.exp(-(((x - centre) / sigma) ** 2) / 2)
        axes.plot(x, y, color="black" if each == word else "0.6", lw=2 if each == word else 1)
        axes.annotate(each, (float(centre), 1.02), ha="center", fontsize=7)
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


def _draw_ticks(axes: Axes, values: FloatArray, height: float, colour: str) -> None:
    axes.plot(values, np.full(len(values), height), "|", color=colour, ms=7)
