"""How far pixels are from a colour's line: the one inner loop of background subtraction.

A colour that is lit more or less moves along the line through black and itself (Horprasert,
Harwood and Davis 1999); what is left after the nearest point of the line is another colour.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from grounding.types import FloatArray

Pixels = NDArray[np.float32]


@njit(cache=True, fastmath={"nnan", "nsz", "contract"})
def line_distances(pixels: Pixels, lines: FloatArray) -> Pixels:
    """Return the distance of each pixel to the nearest of some stretches of lines.

    Args:
        pixels: (N, 3) grey levels, BGR.
        lines: (K, 7) for each line its colour BGR, the darkest and the brightest factor of it,
            how much of a difference in brightness along the stretch counts as distance, and what
            a distance is divided by.

    Returns:
        (N,) the least distance over all lines; infinite without a line.
    """
    squares = np.full(len(pixels), np.inf, np.float32)
    for k in range(len(lines)):
        line = lines[k].astype(np.float32)
        blue, green, red, darkest, brightest, stray, unit = line
        norm = blue * blue + green * green + red * red
        per_norm, per_unit, faint = 1 / norm, 1 / (unit * unit), stray * stray * norm
        for i in range(len(pixels)):
            b, g, r = pixels[i, 0], pixels[i, 1], pixels[i, 2]
            along = (b * blue + g * green + r * red) * per_norm
            factor = min(max(along, darkest), brightest)
            b, g, r = b - factor * blue, g - factor * green, r - factor * red
            faded = np.float32(1) - factor
            square = (b * b + g * g + r * r + faded * faded * faint) * per_unit
            squares[i] = min(squares[i], square)
    return np.sqrt(squares)
