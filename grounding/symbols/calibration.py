"""When to say "unknown": conformal, with a tail for rates that the patches cannot resolve.

The distances of known patches from their words, each under a model that had not seen its
segment, tell how far known things lie. A new distance's p-value is the share of them that lies
farther (Vovk et al. 2005, split conformal). Where fewer than a handful lie farther, that share is
continued by an exponential tail (Pickands 1975, shape 0), which is at least as long as the model
of the next patch, taken under another light, would have it: the known patches may all be of one.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.stats import chi2

from grounding.types import FloatArray

MAX_DISTANCES: Final = 500
_GOLDEN: Final = 0.6180339887498949
_TAIL: Final = 0.02
_HANDFUL: Final = 5
_RARE: Final = 0.001  # where the tail is held to the model,
_MODELLED: Final = 0.01  # which counts the features' resolution twice, and so is wide enough here
_MIN_DECAY: Final = 0.4  # of the distance where the tail begins: outlines err in steps


def thinned(distances: FloatArray) -> FloatArray:
    """Return sorted distances, at most `MAX_DISTANCES`, as evenly spaced quantiles."""
    if len(distances) <= MAX_DISTANCES:
        return np.sort(distances)
    return np.quantile(distances, np.linspace(0, 1, MAX_DISTANCES))


def with_one_more(known: FloatArray, distance: float, turn: int) -> FloatArray:
    """Return sorted distances with one more; at the bound, another one leaves.

    Args:
        known: sorted.
        distance: the new one.
        turn: counts the calls, so that those which leave are spread evenly.
    """
    grown = np.insert(known, int(np.searchsorted(known, distance)), distance)
    if len(grown) <= MAX_DISTANCES:
        return grown
    return np.delete(grown, int(turn * _GOLDEN % 1 * len(grown)))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Calibration:
    """From distances to p-values.

    Attributes:
        known: (M,) sorted distances of known patches.
        share: of the known that lie in the tail.
        start: the distance where the tail begins.
        decay: the distance over which the tail falls to 1 / e.
    """

    known: FloatArray
    share: float
    start: float
    decay: float

    @staticmethod
    def of(known: FloatArray, *, dimension: int) -> "Calibration":
        """Return the calibration by sorted distances (M,), M > 0, over so many features."""
        share = min(0.5, max(_TAIL, _HANDFUL / len(known)))
        start = float(np.quantile(known, 1 - share))
        beyond = known[known > start] - start
        excess = float(np.median(beyond)) / np.log(2) if len(beyond) else 0.0
        modelled = float(np.sqrt(chi2.isf(_MODELLED, dimension))) - start
        decay = max(_MIN_DECAY * start, excess, modelled / np.log(share / _RARE))
        return Calibration(known=known, share=share, start=start, decay=decay)

    def p_value(self, distance: float) -> float:
        """Return the share of known things, in (0, 1], that lie farther."""
        if distance > self.start:
            return self.share * math.exp(-(distance - self.start) / self.decay)
        count = len(self.known)
        farther = count - int(np.searchsorted(self.known, distance))
        return max((1 + farther) / (1 + count), self.share)
