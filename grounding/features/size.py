"""Size features; those in millimetres are unknown (NaN) without a metric scale.

Sizes are logarithms, so that a difference is a ratio and a spread of 0.05 is five per cent.
"""

import math

from grounding.features.patch import MaskedPatch


def pixel_area(patch: MaskedPatch) -> float:
    """Return the area in pixels, as in the paper."""
    return patch.area_px


def log_pixel_area(patch: MaskedPatch) -> float:
    """Return ln of the square root of the area in pixels."""
    return math.log(patch.area_px) / 2


def log_area(patch: MaskedPatch) -> float:
    """Return ln of the square root of the area in square millimetres."""
    return math.log(math.sqrt(patch.area_px)) + _log_scale(patch)


def log_length(patch: MaskedPatch) -> float:
    """Return ln of the longer side of the tightest rectangle in millimetres."""
    return math.log(patch.sides_px[0]) + _log_scale(patch)


def log_width(patch: MaskedPatch) -> float:
    """Return ln of the shorter side of the tightest rectangle in millimetres."""
    return math.log(patch.sides_px[1]) + _log_scale(patch)


def log_height(patch: MaskedPatch) -> float:
    """Return ln of the height in millimetres."""
    return math.log(patch.height_mm) if patch.height_mm else math.nan


def _log_scale(patch: MaskedPatch) -> float:
    return math.log(patch.mm_per_px) if patch.mm_per_px else math.nan
