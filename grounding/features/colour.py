"""Colour features: the paper's means, CIELAB, and hue and saturation as a point in the plane."""

import colorsys

import numpy as np

from grounding.features.patch import MaskedPatch

_DARK = 0.04  # of full brightness


def mean_channel(patch: MaskedPatch, *, channel: int) -> float:
    """Return the mean grey level of a BGR channel."""
    return float(patch.mean_bgr[channel])


def lab(patch: MaskedPatch, *, channel: int) -> float:
    """Return L* (0 to 100), a* or b* of the object's colour."""
    return float(patch.lab[channel])


def saturation_east(patch: MaskedPatch) -> float:
    """Return saturation times the cosine of the hue: 1 is pure red, -1 pure cyan."""
    hue, saturation = _hue_saturation(patch)
    return saturation * float(np.cos(hue))


def saturation_north(patch: MaskedPatch) -> float:
    """Return saturation times the sine of the hue: yellow-green is positive, blue negative."""
    hue, saturation = _hue_saturation(patch)
    return saturation * float(np.sin(hue))


def _hue_saturation(patch: MaskedPatch) -> tuple[float, float]:
    """Return hue in radians and saturation; the darker a colour, the less its tint is believed."""
    blue, green, red = patch.paint_bgr
    hue, _, value = colorsys.rgb_to_hsv(red, green, blue)
    chroma = value - min(red, green, blue)
    return 2 * np.pi * hue, float(chroma / (value + _DARK))
