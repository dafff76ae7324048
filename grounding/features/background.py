"""Tell an object from the table it lies on, or say that there is none.

The table is learnt from the patch's own border: up to three colours, each free to be darker or
brighter along its own line through black, so that shadow and shading stay table (see `lines.py`).
What is left and lies near the middle is the object. Where a region of one colour can be grown from
the middle that is most of it (`top.py`), that region is taken: no side, shadow or stain is in it.
Elsewhere pixels nearer to the table's colour than to the object's (stains, decals that touch it)
are given back to the table.
"""

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from grounding.features.lines import line_distances
from grounding.features.top import grown_top
from grounding.types import ImageArray

Mask = NDArray[np.bool_]
Image32 = NDArray[np.float32]

_BORDER: Final = 0.06  # of the shorter side
_SHADOW: Final = 0.55  # a shadow on the table keeps at least this much of the light
_MIN_RESIDUAL: Final = 13.0  # grey levels: below this two colours are not told apart
_TABLE_COLOURS: Final = 3
_PLAIN: Final = 0.8  # a colour of this merit needs no rival
_MIN_TABLE_SHARE: Final = 0.12  # of the border, for a further table colour
_OBJECT_STRAY: Final = 0.25  # a darker side of an object is still it, but less surely
_STAIN: Final = 3 * _MIN_RESIDUAL  # so far from an object's one colour is another thing
_ONE_COLOUR: Final = 0.6  # of what was found
_FAINT_RESIDUAL: Final = 5.0
_FAINT_BRIGHTNESS: Final = 0.04
_FAINT_AREA: Final = 0.02  # of the patch
_MIN_AREA: Final = 0.003  # of the patch
_MAX_GAP: Final = 0.15  # of the shorter side, from the patch's middle to the object
_MAX_AREA: Final = 0.97  # of the patch
_TABLE_AROUND: Final = 0.6  # of the circumference
_TOP_SHARE: Final = 0.6  # of what stands out: the rest is its sides, shadow or a stain


class NoObjectReason(StrEnum):
    """Why a patch holds no object."""

    ALL_TABLE = "all or mostly table"
    OFF_CENTRE = "nothing near the middle"
    ALL_OBJECT = "no table to tell an object from"
    TOO_SMALL = "patch is too small"


@dataclass(frozen=True, slots=True, kw_only=True)
class NoObject:
    """A patch without an object: noise to learning, an expected absence."""

    reason: NoObjectReason


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _TableColour:
    """One colour of the table, with bounds on its brightness as factors of `bgr`.

    `seen_darkest` and `seen_brightest` are what the border shows; the others leave room for
    shadow and shading.
    """

    bgr: NDArray[np.float32]
    darkest: float
    brightest: float
    seen_darkest: float = 1.0
    seen_brightest: float = 1.0
    threshold: float


def segment_object(image_bgr: ImageArray) -> Mask | NoObject:
    """Return the mask of the object in the middle of a patch.

    Args:
        image_bgr: (H, W, 3) the patch.

    Returns:
        The mask (H, W), one connected piece that may have holes; or NoObject.
    """
    if min(image_bgr.shape[:2]) < 8:
        return NoObject(reason=NoObjectReason.TOO_SMALL)
    table = _table_colours(image_bgr.astype(np.float32), _MIN_RESIDUAL)
    return _beside(table, image_bgr) if table else NoObject(reason=NoObjectReason.ALL_OBJECT)


def _beside(table: list[_TableColour], image_bgr: ImageArray) -> Mask | NoObject:
    """Return the mask of the object beside a table of known colours."""
    blurred = np.asarray(cv2.GaussianBlur(image_bgr, (3, 3), 0), np.uint8)
    smooth = blurred.astype(np.float32)
    residual = _table_residual(smooth, table)
    if np.count_nonzero(residual > 1) > _MAX_AREA * residual.size:
        return NoObject(reason=NoObjectReason.ALL_OBJECT)
    top = grown_top(blurred, [(c.bgr, c.seen_darkest, c.seen_brightest) for c in table])
    if top is not None and _is_most(top, residual > 1):
        return top  # without a look at the pieces of the rest
    found = _central_piece(residual > 1, centre=_centre_of(residual), side=min(residual.shape))
    if top is not None and _is_whole(top, found):
        return top
    if isinstance(found, NoObject):
        return _second_look(image_bgr, found)
    if _border_share(found) > _TABLE_AROUND:
        return NoObject(reason=NoObjectReason.ALL_TABLE)
    return _refined(smooth, found, residual * min(colour.threshold for colour in table))


def _is_whole(top: Mask, found: Mask | NoObject) -> bool:
    """Return whether the face grown from the middle is the thing, beside what stood out.

    It is where it is most of what stood out, or has what did not stand out although it lies
    within; but not the table that is seen through a ring.
    """
    if isinstance(found, NoObject):
        return True
    area, shared = int(np.count_nonzero(top)), int(np.count_nonzero(top & found))
    if shared >= 0.9 * area:
        return _is_most(top, found)
    return shared > 0.1 * area or not _is_within(top, found)


def _is_most(top: Mask, found: Mask) -> bool:
    """Return whether a top lies in what stood out and is most of it."""
    area = int(np.count_nonzero(top))
    return (
        area >= _TOP_SHARE * int(np.count_nonzero(found))
        and int(np.count_nonzero(top & found)) >= 0.9 * area
    )


def _second_look(image_bgr: ImageArray, first: NoObject) -> Mask | NoObject:
    """Look for a thing that hardly stands out: black on dark, white on light; or return `first`.

    Strong smoothing makes a small difference count, and brightness alone may tell the thing.
    """
    smooth = cv2.GaussianBlur(image_bgr, (7, 7), 0).astype(np.float32)
    table = [
        replace(
            colour,
            darkest=colour.seen_darkest * (1 - _FAINT_BRIGHTNESS),
            brightest=colour.seen_brightest * (1 + _FAINT_BRIGHTNESS),
        )
        for colour in _table_colours(smooth, _FAINT_RESIDUAL)
    ]
    if not table:
        return first
    residual = _table_residual(smooth, table)
    found = _central_piece(residual > 1, centre=_centre_of(residual), side=min(residual.shape))
    if isinstance(found, NoObject) or found.mean() < _FAINT_AREA:
        return first
    return found


def _border(image: Image32) -> Image32:
    """Return the pixels of the border (N, 3), thinned to some hundreds."""
    margin = max(2, round(_BORDER * min(image.shape[:2])))
    inner = slice(margin, -margin)
    strips = (image[:margin], image[-margin:], image[inner, :margin], image[inner, -margin:])
    pixels = np.concatenate([strip.reshape(-1, 3) for strip in strips])
    return pixels[:: max(1, len(pixels) // 400)]


def _centre(image: Image32) -> Image32:
    """Return the pixels of the middle (N, 3), thinned."""
    height, width = image.shape[:2]
    part = image[2 * height // 5 : 3 * height // 5 + 1, 2 * width // 5 : 3 * width // 5 + 1]
    pixels = part.reshape(-1, 3)
    return pixels[:: max(1, len(pixels) // 200)]


def _table_colours(image: Image32, least: float) -> list[_TableColour]:
    """Return the colours that the border has and, but for the first, the middle has not."""
    border, centre = _border(image), _centre(image)
    seeds = [_median(border)]
    if _merit(seeds[0], border, centre) < _PLAIN:
        seeds += _corner_colours(image)
    whole, colours = len(border), []
    for turn in range(_TABLE_COLOURS):
        seed = (
            seeds[0]
            if len(seeds) == 1
            else max(seeds, key=lambda seed: _merit(seed, border, centre))
        )
        colour = _fit_colour(border, seed, least)
        left = _residual(border, colour) > colour.threshold
        taken = _residual(centre, colour) <= colour.threshold
        share = np.count_nonzero(~left) / whole
        if share < _MIN_TABLE_SHARE or (turn and len(taken) and taken.mean() > 0.1):
            break
        colours.append(colour)
        border, centre = border[left], centre[~taken]
        if len(border) < _MIN_TABLE_SHARE * whole:
            break
        seeds = [_median(border)]
    return colours


def _corner_colours(image: Image32) -> list[NDArray[np.float32]]:
    """Return the median colours of the corners, which a large thing covers last."""
    side = max(3, min(image.shape[:2]) // 10)
    ends = (slice(0, side), slice(-side, None))
    return [_median(image[rows, cols].reshape(-1, 3)) for rows in ends for cols in ends]


def _merit(seed: NDArray[np.float32], border: Image32, centre: Image32) -> float:
    """Return how much of the border a colour explains, less half of what it does of the middle."""
    rough = _TableColour(bgr=seed, darkest=_SHADOW, brightest=1.4, threshold=3 * _MIN_RESIDUAL)
    return _share(border, rough) - 0.5 * _share(centre, rough)


def _fit_colour(pixels: Image32, seed: NDArray[np.float32], least: float) -> _TableColour:
    """Fit one table colour to the pixels around a seed, robustly."""
    residual, close = _close_residuals(pixels, seed)
    bgr = _median(pixels[residual <= 2.5 * _middle(close) + 2])
    residual, close = _close_residuals(pixels, bgr)
    near = residual <= 2.5 * _middle(close) + 2
    bgr = _median(pixels[near])
    factors = np.sort((pixels[near] @ bgr) / (bgr @ bgr)).tolist()
    darkest, brightest = factors[len(factors) // 100], factors[-1 - len(factors) // 100]
    middle = _middle(close)
    spread = _middle(np.abs(close - middle))
    return _TableColour(
        bgr=bgr,
        darkest=min(_SHADOW, 0.95 * darkest),
        brightest=1.05 * brightest,
        seen_darkest=darkest,
        seen_brightest=brightest,
        threshold=max(least, middle + 9 * spread),
    )


def _close_residuals(pixels: Image32, bgr: NDArray[np.float32]) -> tuple[Image32, Image32]:
    """Return all residuals to a colour, and those that may be of the same colour."""
    wide = _TableColour(bgr=bgr, darkest=_SHADOW, brightest=1.4, threshold=0.0)
    residual = _residual(pixels, wide)
    return residual, residual[residual <= max(4 * _MIN_RESIDUAL, float(residual.min()))]


def _middle(values: Image32) -> float:
    """Return the median of values (N,); the upper one of two."""
    return float(np.partition(values, len(values) // 2)[len(values) // 2])


def _median(pixels: Image32) -> NDArray[np.float32]:
    """Return the median of each channel, at least one grey level, of pixels (N, 3)."""
    middle = len(pixels) // 2
    bgr: NDArray[np.float32] = np.partition(pixels, middle, axis=0)[middle]
    return np.maximum(bgr, np.float32(1))


def _residual(pixels: Image32, colour: _TableColour) -> Image32:
    """Return how far pixels (..., 3) are from a colour's line, in grey levels."""
    return _line_distance(pixels, colour.bgr, (colour.darkest, colour.brightest))


def _line_distance(
    pixels: Image32, bgr: NDArray[np.float32], factors: tuple[float, float], *, stray: float = 0.0
) -> Image32:
    """Return the distance of pixels (..., 3) to a stretch of the line from black through a colour.

    Args:
        pixels: grey levels.
        bgr: (3,) the colour.
        factors: the stretch, darkest and brightest as factors of the colour.
        stray: how much of a difference in brightness along the stretch counts as distance.
    """
    line = np.array([[*bgr.tolist(), *factors, stray, 1.0]])
    distance: Image32 = line_distances(pixels.reshape(-1, 3), line).reshape(pixels.shape[:-1])
    return distance


def _table_residual(pixels: Image32, table: list[_TableColour]) -> Image32:
    """Return how far pixels (H, W, 3) are from the table, in units of what is table still."""
    lines = np.array([[*c.bgr.tolist(), c.darkest, c.brightest, 0.0, c.threshold] for c in table])
    residual: Image32 = line_distances(pixels.reshape(-1, 3), lines).reshape(pixels.shape[:-1])
    return residual


def _share(pixels: Image32, colour: _TableColour) -> float:
    if not len(pixels):
        return 0.0
    return np.count_nonzero(_residual(pixels, colour) <= colour.threshold) / len(pixels)


def _refined(smooth: Image32, found: Mask, residual: Image32) -> Mask:
    """Return the mask without the pixels that are nearer to the table's colour than to its own.

    Where most of what was found has one colour, what has not that colour is a stain beside it.
    """
    x, y, width, height = cv2.boundingRect(found.astype(np.uint8))
    box = (slice(y, y + height), slice(x, x + width))
    pixels, inside = smooth[box], smooth[found]
    inside = inside[:: max(1, len(inside) // 400)]
    line = (_median(inside), (0.3, 1.6))
    nearer = found[box] & (_line_distance(pixels, *line, stray=_OBJECT_STRAY) < residual[box])
    off = _line_distance(inside, *line)
    middle = _middle(off)
    limit = max(_STAIN, middle + 5 * _middle(np.abs(off - middle)))
    if np.count_nonzero(off <= limit) >= _ONE_COLOUR * len(off):
        nearer &= _line_distance(pixels, *line) <= limit
    rows, cols = found.shape
    piece = _central_piece(nearer, centre=(cols / 2 - x, rows / 2 - y), side=min(rows, cols))
    if isinstance(piece, NoObject):
        return found
    refined = np.zeros(found.shape, bool)
    refined[box] = piece
    return refined


def _central_piece(mask: Mask, *, centre: tuple[float, float], side: int) -> Mask | NoObject:
    """Return the connected piece that is large and near the middle of the patch.

    Args:
        mask: (H, W) of the patch or a part of it.
        centre: the patch's middle, x and y in the mask's pixels.
        side: the patch's shorter side in pixels.
    """
    opened = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(opened, connectivity=4)
    areas = stats[1:count, cv2.CC_STAT_AREA]
    large = 1 + np.flatnonzero(areas >= _MIN_AREA * side**2)
    if not len(large):
        return NoObject(reason=NoObjectReason.ALL_TABLE)
    gaps = np.array([_gap(labels == label, centre) for label in large]) / side
    if gaps.min() > _MAX_GAP:
        return NoObject(reason=NoObjectReason.OFF_CENTRE)
    best = large[np.argmax(areas[large - 1] * np.exp(-((gaps / 0.1) ** 2)))]
    return np.asarray(labels == best, bool)


def _border_share(found: Mask) -> float:
    """Return how much of the patch's circumference a mask covers: much of it is the table."""
    rim = (found[0], found[-1], found[:, 0], found[:, -1])
    return sum(int(np.count_nonzero(side)) for side in rim) / (2 * sum(found.shape))


def _is_within(part: Mask, found: Mask) -> bool:
    """Return whether a part lies within the outline of what was found."""
    contours, _ = cv2.findContours(
        found.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE
    )
    outline = np.zeros(found.shape, np.uint8)
    cv2.drawContours(outline, contours, -1, 1, cv2.FILLED)
    return int(np.count_nonzero(outline[part])) > 0.5 * int(np.count_nonzero(part))


def _centre_of(patch: Image32) -> tuple[float, float]:
    return patch.shape[1] / 2, patch.shape[0] / 2


def _gap(piece: Mask, centre: tuple[float, float]) -> float:
    """Return how far a point is from a piece's convex hull, in pixels; 0 inside."""
    contours, _ = cv2.findContours(
        piece.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE
    )
    hull = cv2.convexHull(max(contours, key=len))
    return max(0.0, -float(cv2.pointPolygonTest(hull, centre, measureDist=True)))
