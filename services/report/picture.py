"""Figures as PNG bytes, drawn without a display and without global state."""

import io

from matplotlib.figure import Figure

DPI = 110

# Colours that stay apart for colour-blind readers (Okabe and Ito 2008); None is the last.
INSTRUCTION_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#F0E442")
IDLE_COLOUR = "#999999"


def png_bytes(figure: Figure) -> bytes:
    """Return the figure as a PNG; equal figures give equal bytes."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI, metadata={"Software": None})
    return buffer.getvalue()


def instruction_colour(index: int | None) -> str:
    """Return the colour of an instruction, or the idle colour for none."""
    if index is None:
        return IDLE_COLOUR
    return INSTRUCTION_COLOURS[index % len(INSTRUCTION_COLOURS)]
