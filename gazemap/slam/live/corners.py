"""New corners, spread over the image and away from what is tracked already."""

import cv2
import numpy as np

from gazemap.geometry.arrays import FloatArray, ImageArray

_BORDER_PX = 16


def find_corners(grey: ImageArray, taken_px: FloatArray, *, count: int) -> FloatArray:
    """Return the strongest corner (N, 2) of each free cell of a grid, at most `count` of them.

    Pixels are even, so that they are exact at half resolution too.

    Args:
        grey: (height, width); corners are sought at half resolution.
        taken_px: (M, 2) pixels whose cells are not free.
        count: how many are wanted.
    """
    if count <= 0:
        return np.empty((0, 2))
    half = cv2.pyrDown(grey)
    score = cv2.cornerMinEigenVal(half, 3)
    height, width = score.shape
    cell = max(6, int(np.sqrt(width * height / (count + len(taken_px) + 1.0)) * 0.9))
    rows, columns = height // cell, width // cell
    tiles = score[: rows * cell, : columns * cell].reshape(rows, cell, columns, cell)
    flat = tiles.transpose(0, 2, 1, 3).reshape(rows * columns, cell * cell)
    best = flat.argmax(axis=1)
    strength = flat[np.arange(len(flat)), best]
    tile = np.arange(rows * columns)
    u = 2.0 * ((tile % columns) * cell + best % cell)
    v = 2.0 * ((tile // columns) * cell + best // cell)
    free = _is_free(taken_px, cell_px=2 * cell, shape=(rows, columns)).ravel()
    free &= (u > _BORDER_PX) & (v > _BORDER_PX)
    free &= (u < grey.shape[1] - _BORDER_PX) & (v < grey.shape[0] - _BORDER_PX)
    free &= strength > max(1e-5, 0.002 * float(np.quantile(strength, 0.95)))
    order = np.flatnonzero(free)[np.argsort(-strength[free], kind="stable")][:count]
    return np.column_stack([u[order], v[order]])


def _is_free(
    taken_px: FloatArray, *, cell_px: int, shape: tuple[int, int]
) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    free = np.ones(shape, bool)
    row = (taken_px[:, 1] // cell_px).astype(np.int64)
    column = (taken_px[:, 0] // cell_px).astype(np.int64)
    inside = (row >= 0) & (column >= 0) & (row < shape[0]) & (column < shape[1])
    free[row[inside], column[inside]] = False
    return free
