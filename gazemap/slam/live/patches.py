"""Fixed reference patches: what a point looked like where it was first seen.

Tracking from frame to frame drifts; a patch that is cut once and aligned in every frame does not.
The alignment regresses the image at the present guess on the reference, its gradient and a
constant: gain, offset and shift come out together, and the normal matrix stays the same.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from gazemap.geometry.arrays import FloatArray, ImageArray
from gazemap.geometry.compiled import compiled

RADIUS = 6
_LONGEST_STEP_PX = 2.0
STORED_RADIUS = 15
STORED_SIDE = 2 * STORED_RADIUS + 1
# The reference lives at full and at half resolution; host pixels are even so that both are exact.
LEVELS = 2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pyramid:
    """An image at full and at half resolution; pixel (x, y) of `half` is (2x, 2y) of `full`."""

    full: ImageArray
    half: ImageArray

    @staticmethod
    def of(grey: ImageArray) -> "Pyramid":
        """Return the pyramid of a grey image."""
        return Pyramid(full=grey, half=np.asarray(cv2.pyrDown(grey), dtype=np.uint8))


def cut_patches(pyramid: Pyramid, uv_px: FloatArray) -> ImageArray:
    """Return the references (N, 2, S, S) around even pixels (N, 2); the border is repeated."""
    out = np.empty((len(uv_px), LEVELS, STORED_SIDE, STORED_SIDE), np.uint8)
    for level, image in enumerate((pyramid.full, pyramid.half)):
        r = STORED_RADIUS
        padded = cv2.copyMakeBorder(image, r, r, r, r, cv2.BORDER_REPLICATE)
        centre = np.rint(uv_px / 2**level).astype(np.int64)
        offset = np.arange(STORED_SIDE)
        rows = centre[:, 1, None] + offset
        columns = centre[:, 0, None] + offset
        out[:, level] = padded[rows[:, :, None], columns[:, None, :]]
    return out


@compiled
def _bilinear(image: ImageArray, x: float, y: float) -> float:
    i, j = int(y), int(x)
    a, b = y - i, x - j
    top = (1.0 - b) * image[i, j] + b * image[i, j + 1]
    low = (1.0 - b) * image[i + 1, j] + b * image[i + 1, j + 1]
    value: float = (1.0 - a) * top + a * low
    return value


@compiled
def _warp_reference(reference: ImageArray, m: FloatArray, out: FloatArray) -> bool:
    """Fill out (2R+3, 2R+3) with the reference seen through m (2, 2); False where it ends."""
    r = RADIUS + 1
    reach = r * max(abs(m[0, 0]) + abs(m[0, 1]), abs(m[1, 0]) + abs(m[1, 1]))
    if not reach < STORED_RADIUS - 0.001:
        return False
    for i in range(2 * r + 1):
        for j in range(2 * r + 1):
            dx, dy = float(j - r), float(i - r)
            x = STORED_RADIUS + m[0, 0] * dx + m[0, 1] * dy
            y = STORED_RADIUS + m[1, 0] * dx + m[1, 1] * dy
            out[i, j] = _bilinear(reference, x, y)
    return True


@compiled
def _design(warped: FloatArray, design: FloatArray) -> FloatArray:
    """Fill design (n, 5) with gradient x, y, value, one, weight; return the normal matrix."""
    normal = np.zeros((4, 4))
    k = 0
    for i in range(1, 2 * RADIUS + 2):
        for j in range(1, 2 * RADIUS + 2):
            dx, dy = j - RADIUS - 1, i - RADIUS - 1
            weight = np.exp(-(dx * dx + dy * dy) / (2.0 * 16.0))
            design[k, 0] = 0.5 * (warped[i, j + 1] - warped[i, j - 1])
            design[k, 1] = 0.5 * (warped[i + 1, j] - warped[i - 1, j])
            design[k, 2] = warped[i, j]
            design[k, 3] = 1.0
            design[k, 4] = weight
            for a in range(4):
                for b in range(a, 4):
                    normal[a, b] += weight * design[k, a] * design[k, b]
            k += 1
    for a in range(4):
        for b in range(a):
            normal[a, b] = normal[b, a]
    return normal


@compiled
def _regress(
    image: ImageArray, x: float, y: float, design: FloatArray, moments: FloatArray
) -> bool:
    """Sum moments (6,): the image against the design's columns, and its own square; weighted."""
    r = RADIUS
    if not (x > r and y > r and x < image.shape[1] - r - 2 and y < image.shape[0] - r - 2):
        return False
    moments[:] = 0.0
    i, j = int(y), int(x)
    a, b = y - i, x - j
    w00, w01, w10, w11 = (1 - a) * (1 - b), (1 - a) * b, a * (1 - b), a * b
    k = 0
    for p in range(i - r, i + r + 1):
        for q in range(j - r, j + r + 1):
            top = w00 * image[p, q] + w01 * image[p, q + 1]
            value = top + w10 * image[p + 1, q] + w11 * image[p + 1, q + 1]
            weighted = design[k, 4] * value
            moments[0] += weighted * design[k, 0]
            moments[1] += weighted * design[k, 1]
            moments[2] += weighted * design[k, 2]
            moments[3] += weighted
            moments[4] += weighted * value
            k += 1
    return True


@compiled
def _zncc(normal: FloatArray, moments: FloatArray) -> float:
    """Return the weighted correlation of image and reference."""
    total = normal[3, 3]
    var_reference = normal[2, 2] - normal[2, 3] ** 2 / total
    var_image = moments[4] - moments[3] ** 2 / total
    if var_reference < 1.0 * total or var_image < 1.0 * total:
        return -1.0
    shared = moments[2] - moments[3] * normal[2, 3] / total
    correlation: float = shared / np.sqrt(var_reference * var_image)
    return correlation


@compiled
def _step(inverse: FloatArray, moments: FloatArray, step: FloatArray) -> bool:
    """Fill step (2,) from the regression on gradient, value and one; False without a gain."""
    regressed = inverse @ moments[:4]
    if not regressed[2] > 0.1:
        return False
    step[0], step[1] = -regressed[0] / regressed[2], -regressed[1] / regressed[2]
    length = np.sqrt(step[0] * step[0] + step[1] * step[1])
    if length > _LONGEST_STEP_PX:
        step *= _LONGEST_STEP_PX / length
    return True


@compiled
def _align_one(
    image: ImageArray, design: FloatArray, normal: FloatArray, start: FloatArray, reach: float
) -> tuple[float, float, float]:
    """Return x, y and the correlation there; -1 for a correlation where it failed."""
    for a in range(4):
        normal[a, a] += 1e-6 * (normal[a, a] + 1.0)
    inverse = np.linalg.inv(normal).astype(np.float64)
    at, step, moments = start.copy(), np.empty(2), np.zeros(6)
    for _ in range(12):
        if not _regress(image, at[0], at[1], design, moments):
            return at[0], at[1], -1.0
        if not _step(inverse, moments, step):
            return at[0], at[1], -1.0
        at += step
        if not np.abs(at - start).max() < reach:
            return at[0], at[1], -1.0
        if np.abs(step).max() < 0.015:
            break
    if not _regress(image, at[0], at[1], design, moments):
        return at[0], at[1], -1.0
    return at[0], at[1], _zncc(normal, moments)


@compiled
def _align_level(
    image: ImageArray,
    references: ImageArray,
    from_image: FloatArray,
    uv_px: FloatArray,
    reach: float,
    level: int,
) -> FloatArray:
    side = 2 * RADIUS + 3
    warped = np.empty((side, side))
    design = np.empty(((2 * RADIUS + 1) ** 2, 5))
    out = np.empty((len(uv_px), 3))
    for j in range(len(uv_px)):
        start = uv_px[j] / 2.0**level
        out[j, 0], out[j, 1], out[j, 2] = start[0], start[1], -1.0
        size = np.sqrt(abs(np.linalg.det(from_image[j]))) * 2.0**level
        stored = 1 if size > 1.4 else 0
        m = from_image[j] * 2.0 ** (level - stored)
        if np.isfinite(size) and _warp_reference(references[j, stored], m, warped):
            normal = _design(warped, design)
            out[j, 0], out[j, 1], out[j, 2] = _align_one(image, design, normal, start, reach)
        out[j, 0] *= 2.0**level
        out[j, 1] *= 2.0**level
    return out


def align_patches(
    pyramid: Pyramid,
    references: ImageArray,
    from_image: FloatArray,
    uv_px: FloatArray,
    *,
    coarse: bool = False,
    reach_px: float = 4.0,
) -> tuple[FloatArray, FloatArray]:
    """Find patches in an image.

    Args:
        pyramid: the image.
        references: (N, 2, S, S) from `cut_patches`.
        from_image: (N, 2, 2) maps pixel offsets here to pixel offsets in the reference.
        uv_px: (N, 2) predictions.
        coarse: whether half resolution goes first, which doubles the reach.
        reach_px: how far from its prediction a patch may be found at full resolution.

    Returns:
        Positions (N, 2) in pixels and correlations (N,); a correlation of -1 is a failure.
    """
    start = uv_px
    if coarse:
        first = _align_level(pyramid.half, references, from_image, start, reach_px, 1)
        start = np.where(first[:, 2:] > 0.6, first[:, :2], start)
    found = _align_level(pyramid.full, references, from_image, start, reach_px, 0)
    return found[:, :2], found[:, 2]
