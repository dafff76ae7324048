"""Counts of the colours inside and outside of silhouettes; compiled, for each fit asks often."""

from typing import Any

import numpy as np
from numba import njit

Array = np.ndarray[Any, Any]


@njit(cache=True)
def count_colours(
    bins: Array, shaded: Array, valid: Array, masks: Array, views: Array, bin_count: int
) -> tuple[Array, Array, Array]:
    """Count each colour inside the silhouettes, outside, and what outside would be in shadow.

    Args:
        bins: (V, n, n) the colour of each pixel.
        shaded: (V, m, m, S) its darker versions at every n // m th pixel or so.
        valid: (V, n, n) which pixels say anything.
        masks: (V, n, n) which are inside.
        views: (K,) which of the V cut-outs are counted.
        bin_count: how many colours there are.

    Returns:
        Three arrays (bin_count,) of counts.
    """
    inside, outside = np.zeros(bin_count), np.zeros(bin_count)
    in_shadow = np.zeros(bin_count)
    side, few, shades = bins.shape[1], shaded.shape[1], shaded.shape[3]
    stride = (side + few - 1) // few
    for i in views:
        for v in range(side):
            for u in range(side):
                if not valid[i, v, u]:
                    continue
                if masks[i, v, u]:
                    inside[bins[i, v, u]] += 1
                    continue
                outside[bins[i, v, u]] += 1
                if v % stride == 0 and u % stride == 0:
                    for s in range(shades):
                        in_shadow[shaded[i, v // stride, u // stride, s]] += 1
    return inside, outside, in_shadow


@njit(cache=True)
def spread_ratio(ratio: Array, bins: Array, valid: Array, views: Array, odds: Array) -> None:
    """Write each pixel's ratio (bin_count,) into odds (V, n, n), but where it says nothing."""
    for i in views:
        for v in range(bins.shape[1]):
            for u in range(bins.shape[2]):
                if valid[i, v, u]:
                    odds[i, v, u] = ratio[bins[i, v, u]]
