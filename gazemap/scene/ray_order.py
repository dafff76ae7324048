"""Puts rays that pass close to each other next to each other.

A tree of two million triangles is far larger than a processor's cache. Rays in the order in which
they come jump about in it; neighbours find the nodes and triangles of the ray before them there.
Compiled, for the order must cost less than it saves.

Source:
    Z-order of Morton 1966, of the point of each ray nearest to the middle of the surface: unlike
    the direction it tells rays of different origins apart. Sorted by counting.
"""

from typing import Any

import numpy as np
from numba import njit

from gazemap.geometry.arrays import FloatArray, IntArray

_BITS = 9  # along each of the two axes in which the points spread most
MIN_RAYS = 4096  # for fewer the order does not pay
Float32Array = np.ndarray[Any, np.dtype[np.float32]]
_Array = np.ndarray[Any, Any]


def coherent_order(rays_world: Float32Array, middle_world: FloatArray) -> IntArray:
    """Return the indices (N,) that bring rays (N, 6), origin and unit direction, into Z-order."""
    order: IntArray = _counted(_keys(rays_world, middle_world))
    return order


@njit(cache=True)
def _keys(rays: _Array, middle: _Array) -> _Array:
    """Return the cell (N,) of each ray's point nearest to the middle."""
    count = len(rays)
    nearest = np.empty((count, 3), dtype=np.float32)
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for i in range(count):
        along = 0.0
        for k in range(3):
            along += (middle[k] - rays[i, k]) * rays[i, 3 + k]
        for k in range(3):
            at = rays[i, k] + along * rays[i, 3 + k]
            nearest[i, k] = at
            low[k], high[k] = min(low[k], at), max(high[k], at)
    widest = np.argsort(high - low)[1:]
    keys = np.zeros(count, dtype=np.int32)
    for n in range(2):
        k = widest[n]
        scale = 2**_BITS / max(high[k] - low[k], 1e-9)
        for i in range(count):
            cell = min(max(int((nearest[i, k] - low[k]) * scale), 0), 2**_BITS - 1)
            for bit in range(_BITS):
                keys[i] |= ((cell >> bit) & 1) << (2 * bit + n)
    return keys


@njit(cache=True)
def _counted(keys: _Array) -> _Array:
    """Return the indices (N,) that sort the keys, equal ones in their own order."""
    ends = np.zeros(2 ** (2 * _BITS) + 1, dtype=np.int64)
    for key in keys:
        ends[key + 1] += 1
    for cell in range(1, len(ends)):
        ends[cell] += ends[cell - 1]
    order = np.empty(len(keys), dtype=np.int64)
    for i in range(len(keys)):
        order[ends[keys[i]]] = i
        ends[keys[i]] += 1
    return order
