"""The silhouette of a box, row by row; compiled, for a fit evaluates it thousands of times."""

from typing import Any

import numpy as np
from numba import njit

from gazemap.geometry.arrays import BoolArray, FloatArray

# Corner k of a box has the sign of bit 0, 1, 2 of k along x, y, z; edges join corners that
# differ in one bit.
_EDGES = np.array(
    [(a, a | bit) for bit in (1, 2, 4) for a in range(8) if not a & bit], dtype=np.int64
)
_BEHIND_M = 1e-3


@njit(cache=True)
def row_extents(
    shape: np.ndarray[Any, Any], projection: np.ndarray[Any, Any], size_px: int
) -> np.ndarray[Any, Any]:
    """Return where the silhouette of a box begins and ends in each row (size_px, 2).

    The silhouette of a convex body is what its edges enclose in each row. Rows without it begin
    after they end.

    Args:
        shape: (7,) centre x, y, z, yaw, length, width, height; world frame, metres and radians.
        projection: (3, 4) world to pixel.
        size_px: side of the image.
    """
    corners = np.empty((8, 2))
    c, s = np.cos(shape[3]), np.sin(shape[3])
    for k in range(8):
        dx = shape[4] * (0.5 if k & 1 else -0.5)
        dy = shape[5] * (0.5 if k & 2 else -0.5)
        dz = shape[6] * (0.5 if k & 4 else -0.5)
        x, y, z = shape[0] + c * dx - s * dy, shape[1] + s * dx + c * dy, shape[2] + dz
        p = projection
        depth = max(p[2, 0] * x + p[2, 1] * y + p[2, 2] * z + p[2, 3], _BEHIND_M)
        corners[k, 0] = (p[0, 0] * x + p[0, 1] * y + p[0, 2] * z + p[0, 3]) / depth
        corners[k, 1] = (p[1, 0] * x + p[1, 1] * y + p[1, 2] * z + p[1, 3]) / depth
    extents = np.empty((size_px, 2))
    extents[:, 0], extents[:, 1] = np.inf, -np.inf
    for e in range(12):
        a, b = _EDGES[e, 0], _EDGES[e, 1]
        if corners[a, 1] > corners[b, 1]:
            a, b = b, a
        top, bottom = corners[a, 1], corners[b, 1]
        first, last = max(int(np.ceil(top)), 0), min(int(np.floor(bottom)), size_px - 1)
        for v in range(first, last + 1):
            along = 0.0 if bottom == top else (v - top) / (bottom - top)
            u = corners[a, 0] + along * (corners[b, 0] - corners[a, 0])
            extents[v, 0] = min(extents[v, 0], u)
            extents[v, 1] = max(extents[v, 1], u)
    return extents


@njit(cache=True)
def _up_to(sums: np.ndarray[Any, Any], u: float) -> float:
    """Return the sum of a row of pixels left of u, where pixel k covers k - 0.5 to k + 0.5."""
    at = min(max(u + 0.5, 0.0), len(sums) - 1.0)
    k = min(int(at), len(sums) - 2)
    return float(sums[k] + (at - k) * (sums[k + 1] - sums[k]))


@njit(cache=True)
def sum_inside(
    shape: np.ndarray[Any, Any], projections: np.ndarray[Any, Any], sums: np.ndarray[Any, Any]
) -> float:
    """Return the sum of all pixels inside a box's silhouettes over all views.

    Args:
        shape: (7,) as in `row_extents`.
        projections: (V, 3, 4) world to pixel.
        sums: (V, n, n + 1) running sums of each row, from 0.
    """
    total = 0.0
    for i in range(len(projections)):
        extents = row_extents(shape, projections[i], sums.shape[1])
        for v in range(extents.shape[0]):
            if extents[v, 1] > extents[v, 0]:
                total += _up_to(sums[i, v], extents[v, 1]) - _up_to(sums[i, v], extents[v, 0])
    return total


@njit(cache=True)
def masks_inside(
    shape: np.ndarray[Any, Any], projections: np.ndarray[Any, Any], size_px: int
) -> np.ndarray[Any, Any]:
    """Return the silhouettes of a box in several views as masks (V, size_px, size_px)."""
    masks = np.zeros((len(projections), size_px, size_px), dtype=np.bool_)
    for i in range(len(projections)):
        extents = row_extents(shape, projections[i], size_px)
        for v in range(size_px):
            for u in range(size_px):
                masks[i, v, u] = extents[v, 0] <= u <= extents[v, 1]
    return masks


def mask_inside(shape: FloatArray, projection: FloatArray, size_px: int) -> BoolArray:
    """Return the silhouette of a box as a mask (size_px, size_px)."""
    return np.asarray(masks_inside(shape, projection[None], size_px)[0])
