"""Grow the top of a thing from the middle of a patch.

What differs from the table may be hard to tell by colour alone: black on dark, white on light, a
shadow beside a grey thing. But a thing lies in the middle and its top has one colour, so the
region of that colour around the middle is its top, if it ends before the patch does.
"""

import functools
from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from grounding.features.lines import line_distances
from grounding.types import ImageArray

Mask = NDArray[np.bool_]
TableLine = tuple[NDArray[np.float32], float, float]

_TOLERANCE: Final = 0.4  # of the difference to the table
_LEAST_TOLERANCE: Final = 4.0  # grey levels
_MOST_TOLERANCE: Final = 32.0
_NOISE_SIGMAS: Final = 2.5
_LEAST_AREA: Final = 0.003  # of the patch
_AT_BORDER: Final = 0.02  # of the patch's circumference
_SOLID: Final = 0.85  # of the hull, at least
_STEP: Final = 1.5  # from one tolerance to the next
_STABLE: Final = 1.1  # a region that grows by less has found its edge
_LEAK: Final = 0.15  # of the root of the area: what is thinner leaked out
_EDGE_PX: Final = 2
_MOST_AREA: Final = 0.9  # of the patch


def grown_top(blurred_bgr: ImageArray, table: Sequence[TableLine]) -> Mask | None:
    """Return the region of one colour about the middle, or None if it is no thing's top.

    Args:
        blurred_bgr: (H, W, 3) the patch, slightly smoothed.
        table: colours of the table with the darkest and the brightest factor of each.
    """
    height, width = blurred_bgr.shape[:2]
    reach = max(1, min(height, width) // 24)
    rows = slice(height // 2 - reach, height // 2 + reach + 1)
    cols = slice(width // 2 - reach, width // 2 + reach + 1)
    window = blurred_bgr[rows, cols].astype(np.float32)
    colour = np.median(window.reshape(-1, 3), axis=0).astype(np.float32)
    least, most = _tolerances(window, colour, table)
    off = np.abs(window - colour).max(axis=-1)
    row, col = divmod(int(np.argmin(off)), window.shape[1])
    seed = (cols.start + col, rows.start + row)
    before = _grown(blurred_bgr, seed, least)
    while least < most:
        least = min(most, _STEP * least)
        grown = _grown(blurred_bgr, seed, least)
        if np.count_nonzero(grown) <= _STABLE * np.count_nonzero(before):
            top = _as_top(grown)
            if top is not None:
                return _to_the_edge(top, blurred_bgr, colour)
        before = grown
    top = _as_top(before)
    return None if top is None else _to_the_edge(top, blurred_bgr, colour)


def _to_the_edge(top: ImageArray, image_bgr: ImageArray, colour: NDArray[np.float32]) -> Mask:
    """Return a top with the blurred pixels of its edge that are more its own than what is beside.

    A small tolerance ends where the edge begins; the edge itself is half-way between both sides.
    """
    x, y, width, height = cv2.boundingRect(top)
    box = (
        slice(max(0, y - _EDGE_PX), y + height + _EDGE_PX),
        slice(max(0, x - _EDGE_PX), x + width + _EDGE_PX),
    )
    channels = (np.abs(image_bgr[box][..., c] - colour[c]) for c in range(3))
    off = functools.reduce(np.maximum, channels)
    beside = cv2.dilate(off, np.ones((2 * _EDGE_PX + 1,) * 2, np.uint8))
    near = cv2.dilate(top[box], np.ones((2 * _EDGE_PX - 1,) * 2, np.uint8)) > 0
    whole = top > 0
    whole[box] |= near & (off < 0.5 * np.asarray(beside))
    return whole


def _grown(image_bgr: ImageArray, seed: tuple[int, int], tolerance: float) -> ImageArray:
    """Return the region (H, W) around a seed whose colour is the seed's, up to a tolerance."""
    height, width = image_bgr.shape[:2]
    region = np.zeros((height + 2, width + 2), np.uint8)
    flags = cv2.FLOODFILL_FIXED_RANGE | cv2.FLOODFILL_MASK_ONLY | 4
    cv2.floodFill(image_bgr, region, seed, 0, (tolerance,) * 3, (tolerance,) * 3, flags)
    return region[1:-1, 1:-1]


def _tolerances(
    window: NDArray[np.float32], colour: NDArray[np.float32], table: Sequence[TableLine]
) -> tuple[float, float]:
    """Return by how many grey levels a top varies at least, and at most: less on a like table."""
    lines = np.array(
        [[*bgr.tolist(), darkest, brightest, 1.0, 1.0] for bgr, darkest, brightest in table]
    )
    apart = float(line_distances(colour[None], lines)[0])
    noise = 1.05 * float(np.median(np.abs(np.diff(window, axis=1))))
    least = max(_LEAST_TOLERANCE, _NOISE_SIGMAS * noise)
    return least, max(least, min(_MOST_TOLERANCE, _TOLERANCE * apart))


def _as_top(region: ImageArray) -> ImageArray | None:
    """Return the region without what leaked out of it and its holes, or None if it is no top."""
    area = np.count_nonzero(region)
    if not _LEAST_AREA * region.size <= area <= _MOST_AREA * region.size:
        return None
    rim = (region[0], region[-1], region[:, 0], region[:, -1])
    if sum(np.count_nonzero(side) for side in rim) > _AT_BORDER * 2 * sum(region.shape):
        return None
    reach = max(3, int(_LEAK * area**0.5) | 1)
    x, y, width, height = cv2.boundingRect(region)
    box = (
        slice(max(0, y - reach), y + height + reach),
        slice(max(0, x - reach), x + width + reach),
    )
    found = _solid_core(region[box], reach)
    if found is None:
        return None
    top = np.zeros(region.shape, np.uint8)
    top[box] = found
    return top


def _solid_core(region: ImageArray, reach: int) -> ImageArray | None:
    """Return a region (h, w), holes filled, without what is thinner than `reach`, if not ragged."""
    outline = _outline(region)
    if outline is None:
        return None
    filled = np.zeros(region.shape, np.uint8)
    cv2.drawContours(filled, [outline], -1, 1, cv2.FILLED)
    brush = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))
    core = cv2.morphologyEx(filled, cv2.MORPH_OPEN, brush)
    filled &= np.asarray(cv2.dilate(core, np.ones((3, 3), np.uint8)))
    outline = _outline(filled)
    if outline is None:
        return None
    mask = np.zeros(region.shape, np.uint8)
    cv2.drawContours(mask, [outline], -1, 1, cv2.FILLED)
    hull = cv2.contourArea(cv2.convexHull(outline))
    return mask if cv2.contourArea(outline) >= _SOLID * hull else None


def _outline(region: ImageArray) -> NDArray[np.int32] | None:
    contours, _ = cv2.findContours(region, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    return np.asarray(max(contours, key=cv2.contourArea), np.int32) if contours else None
