"""Compiled inner loops of patch alignment: one template a point, inverse-compositional steps.

A template is brought to mean 0 and deviation 1 under a Gaussian weight. What a change of gain or
offset would do is taken out of its slopes once, so that the steps in a frame need neither.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray, IntArray

_FLATTEST_GREY = 2.0
_LONGEST_STEP_PX = 2.0
_SHORTEST_STEP_PX = 0.01
_HOPELESS_AFTER = 4
_HOPELESS_ZNCC = 0.4


class References(NamedTuple):
    """Templates of P points with S samples each, on one pyramid level (a tuple, for numba).

    Attributes:
        template: (P, S).
        slope: (P, 2, S) along x and y, per pixel.
        inverse: (P, 2, 2) of the slopes' second moments.
        is_usable: (P,) whether a template was cut and has texture in two directions.
        weight: (S,) adds up to 1.
    """

    template: NDArray[np.float32]
    slope: NDArray[np.float32]
    inverse: FloatArray
    is_usable: BoolArray
    weight: FloatArray


class Windows(NamedTuple):
    """Where N templates are looked for in a frame (a tuple, for numba).

    Attributes:
        point: (N,) index of the template.
        uv: (N, 2) pixel of the centre; moved.
        zncc: (N,) correlation there, -1 where it cannot be told; set.
        warp: (N, 2, 2) maps offsets in the template to offsets in the frame.
    """

    point: IntArray
    uv: FloatArray
    zncc: FloatArray
    warp: FloatArray


def no_references(count: int, weight: FloatArray) -> References:
    """Return room for the templates of so many points."""
    return References(
        template=np.zeros((count, weight.size), dtype=np.float32),
        slope=np.zeros((count, 2, weight.size), dtype=np.float32),
        inverse=np.zeros((count, 2, 2)),
        is_usable=np.zeros(count, dtype=np.bool_),
        weight=weight,
    )


@njit(cache=True, nogil=True)
def _sample(image: ImageArray, u: float, v: float) -> float:
    """Return the bilinear brightness; the caller keeps (u, v) inside."""
    x, y = int(u), int(v)
    a, b = u - x, v - y
    top = image[y, x] * (1.0 - a) + image[y, x + 1] * a
    bottom = image[y + 1, x] * (1.0 - a) + image[y + 1, x + 1] * a
    return float(top * (1.0 - b) + bottom * b)


@njit(cache=True, nogil=True)
def cut(image: ImageArray, uv: FloatArray, points: IntArray, references: References) -> None:
    """Cut the templates of points (N,) at pixels uv (N, 2)."""
    side = int(np.sqrt(references.weight.size))
    edge = side // 2 + 1.5
    height, width = image.shape
    for n in range(len(points)):
        j = points[n]
        u, v = uv[n, 0], uv[n, 1]
        references.is_usable[j] = False
        if edge <= u <= width - 1 - edge and edge <= v <= height - 1 - edge:
            _read(image, u, v, references.template[j], references.slope[j])
            references.is_usable[j] = _normalise(references, j)


@njit(cache=True, nogil=True)
def _read(
    image: ImageArray, u: float, v: float, template: NDArray[np.float32], slope: NDArray[np.float32]
) -> None:
    side = int(np.sqrt(template.size))
    half = side // 2
    for k in range(template.size):
        x, y = u + k % side - half, v + k // side - half
        template[k] = _sample(image, x, y)
        slope[0, k] = _sample(image, x + 0.5, y) - _sample(image, x - 0.5, y)
        slope[1, k] = _sample(image, x, y + 0.5) - _sample(image, x, y - 0.5)


@njit(cache=True, nogil=True)
def _normalise(references: References, j: int) -> bool:
    """Bring template j to mean 0 and deviation 1; return whether it can be located."""
    template, slope = references.template[j], references.slope[j]
    weight = references.weight
    template -= np.float32((weight * template).sum())
    deviation = np.sqrt((weight * template * template).sum())
    if deviation < _FLATTEST_GREY:
        return False
    template /= np.float32(deviation)
    slope /= np.float32(deviation)
    for d in range(2):
        mean, along = (weight * slope[d]).sum(), (weight * slope[d] * template).sum()
        slope[d] -= (mean + along * template).astype(np.float32)
    xx, yy = (weight * slope[0] * slope[0]).sum(), (weight * slope[1] * slope[1]).sum()
    xy = (weight * slope[0] * slope[1]).sum()
    determinant = xx * yy - xy * xy
    if determinant < 1e-6:
        return False
    inverse = references.inverse[j]
    inverse[0, 0], inverse[1, 1] = yy / determinant, xx / determinant
    inverse[0, 1] = inverse[1, 0] = -xy / determinant
    return True


@njit(cache=True, nogil=True)
def align(image: ImageArray, references: References, windows: Windows, iterations: int) -> None:
    """Move each window until it matches its template."""
    side = int(np.sqrt(references.weight.size))
    half = side // 2
    height, width = image.shape
    for n in range(len(windows.point)):
        if not references.is_usable[windows.point[n]]:
            continue
        warp, uv = windows.warp[n], windows.uv[n]
        reach_u = half * (abs(warp[0, 0]) + abs(warp[0, 1])) + 1.0
        reach_v = half * (abs(warp[1, 0]) + abs(warp[1, 1])) + 1.0
        for attempt in range(iterations):
            inside_u = reach_u < uv[0] < width - 1 - reach_u
            if not (inside_u and reach_v < uv[1] < height - 1 - reach_v):
                windows.zncc[n] = -1.0
                break
            step_px, windows.zncc[n] = _step(image, references, windows.point[n], warp, uv)
            hopeless = attempt == _HOPELESS_AFTER and windows.zncc[n] < _HOPELESS_ZNCC
            if hopeless or step_px < _SHORTEST_STEP_PX:
                break


@njit(cache=True, nogil=True)
def _step(
    image: ImageArray, references: References, j: int, warp: FloatArray, uv: FloatArray
) -> tuple[float, float]:
    """Take one step of uv (2,); return its length in template pixels and the correlation before."""
    product, deviation, s0, s1 = _compare(image, references, j, warp, uv)
    if deviation < 1.0:
        return 0.0, -1.0
    inverse = references.inverse[j]
    # The slopes know nothing of mean and template, so the gain is all there is to undo.
    gain = max(product, 1e-3)
    d0 = (inverse[0, 0] * s0 + inverse[0, 1] * s1) / gain
    d1 = (inverse[1, 0] * s0 + inverse[1, 1] * s1) / gain
    length = np.sqrt(d0 * d0 + d1 * d1)
    if length > _LONGEST_STEP_PX:
        d0, d1 = d0 * _LONGEST_STEP_PX / length, d1 * _LONGEST_STEP_PX / length
    uv[0] -= warp[0, 0] * d0 + warp[0, 1] * d1
    uv[1] -= warp[1, 0] * d0 + warp[1, 1] * d1
    return length, product / deviation


@njit(cache=True, nogil=True)
def _compare(
    image: ImageArray, references: References, j: int, warp: FloatArray, uv: FloatArray
) -> tuple[float, float, float, float]:
    """Return the window's product with the template, its deviation, products with the slopes."""
    weight = references.weight
    template, slope = references.template[j], references.slope[j]
    side = int(np.sqrt(weight.size))
    half = side // 2
    mean, square, product, s0, s1 = 0.0, 0.0, 0.0, 0.0, 0.0
    k = 0
    for dy in range(-half, half + 1):
        u = uv[0] + warp[0, 1] * dy - warp[0, 0] * half
        v = uv[1] + warp[1, 1] * dy - warp[1, 0] * half
        for _ in range(side):
            value = _sample(image, u, v)
            weighted = weight[k] * value
            mean += weighted
            square += weighted * value
            product += weighted * template[k]
            s0 += weighted * slope[0, k]
            s1 += weighted * slope[1, k]
            u += warp[0, 0]
            v += warp[1, 0]
            k += 1
    return product, np.sqrt(max(square - mean * mean, 0.0)), s0, s1
