"""How far pixels are from a colour's line: the one inner loop of background subtraction.

A colour that is lit more or less moves along the line through black and itself (Horprasert,
Harwood and Davis 1999); what is left after the nearest point of the line is another colour.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from grounding.types import FloatArray

Pixels = NDArray[np.float32]


@njit(cache=True)
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
    nearest = np.empty(len(pixels), np.float32)
    norms = lines[:, 0] ** 2 + lines[:, 1] ** 2 + lines[:, 2] ** 2
    per_norm, per_unit = 1 / norms, 1 / lines[:, 6] ** 2
    for i in range(len(pixels)):
        blue, green, red = pixels[i, 0], pixels[i, 1], pixels[i, 2]
        best = np.inf
        for k in range(len(lines)):
            along = blue * lines[k, 0] + green * lines[k, 1] + red * lines[k, 2]
            factor = min(max(along * per_norm[k], lines[k, 3]), lines[k, 4])
            across = blue - factor * lines[k, 0]
            squared = across * across
            across = green - factor * lines[k, 1]
            squared += across * across
            across = red - factor * lines[k, 2]
            squared += across * across
            faded = lines[k, 5] * (1 - factor)
            best = min(best, (squared + faded * faded * norms[k]) * per_unit[k])
        nearest[i] = np.sqrt(best)
    return nearest
