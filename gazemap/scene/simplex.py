"""The search for the box that gathers most: Nelder and Mead's simplex, compiled with its score."""

from typing import Any

import numpy as np
from numba import njit

from gazemap.scene.silhouette import sum_inside

Problem = tuple[
    np.ndarray[Any, Any],  # (K,) which of the seven numbers are searched
    np.ndarray[Any, Any],  # (7,) first guess, as in `silhouette`; the level it stands on stays
    np.ndarray[Any, Any],  # (2, 3) least and most length, width, height
    np.ndarray[Any, Any],  # (V, 3, 4) projections
    np.ndarray[Any, Any],  # (V, n, n + 1) running sums
]
_OUT_OF_BOUNDS = 1e9
_SPREAD_TOLERANCE = 0.5


@njit(cache=True)
def _completed(free: np.ndarray[Any, Any], problem: Problem) -> np.ndarray[Any, Any]:
    """Return the shape (7,) of the searched numbers (K,); its base stays where it was."""
    at, start = problem[0], problem[1]
    shape = start.copy()
    for k in range(len(at)):
        shape[at[k]] = free[k]
    shape[2] = start[2] - start[6] / 2 + shape[6] / 2
    return shape


@njit(cache=True)
def _cost(free: np.ndarray[Any, Any], problem: Problem) -> float:
    """Return minus what a box gathers."""
    shape, limits = _completed(free, problem), problem[2]
    for k in range(3):
        if shape[4 + k] < limits[0, k] or shape[4 + k] > limits[1, k]:
            return _OUT_OF_BOUNDS
    return -sum_inside(shape, problem[3], problem[4])


@njit(cache=True)
def _improve(corners: np.ndarray[Any, Any], costs: np.ndarray[Any, Any], problem: Problem) -> int:
    """Replace the worst corner of a sorted simplex, or shrink it; return the evaluations used."""
    n = len(costs) - 1
    middle = corners[:n].sum(axis=0) / n
    reflected = 2 * middle - corners[n]
    cost = _cost(reflected, problem)
    if cost < costs[0]:
        further = 3 * middle - 2 * corners[n]
        cost_further = _cost(further, problem)
        if cost_further < cost:
            corners[n], costs[n] = further, cost_further
        else:
            corners[n], costs[n] = reflected, cost
        return 2
    if cost < costs[n]:
        corners[n], costs[n] = reflected, cost
    if cost < costs[n - 1]:
        return 1
    inner = (middle + corners[n]) / 2
    cost_inner = _cost(inner, problem)
    if cost_inner < costs[n]:
        corners[n], costs[n] = inner, cost_inner
        return 2
    for k in range(1, n + 1):
        corners[k] = (corners[0] + corners[k]) / 2
        costs[k] = _cost(corners[k], problem)
    return 2 + n


@njit(cache=True)
def climb(
    problem: Problem, steps: np.ndarray[Any, Any], tolerance: float, most: int
) -> np.ndarray[Any, Any]:
    """Return the shape (7,) near the first guess that gathers most within its silhouettes.

    Args:
        problem: what is searched, and in what.
        steps: (K,) size of the first simplex.
        tolerance: of the simplex, in the unit of each number.
        most: how many evaluations at most.

    Source:
        Nelder and Mead 1965, with the usual factors 1, 2, 1/2, 1/2.
    """
    n = len(steps)
    corners, costs = np.empty((n + 1, n)), np.empty(n + 1)
    for k in range(n + 1):
        corners[k] = problem[1][problem[0]]
        if k > 0:
            corners[k, k - 1] += steps[k - 1]
        costs[k] = _cost(corners[k], problem)
    used = n + 1
    while used < most:
        order = np.argsort(costs)
        corners, costs = corners[order], costs[order]
        size = np.abs(corners - corners[0]).max()
        if costs[n] - costs[0] < _SPREAD_TOLERANCE and size < tolerance:
            break
        used += _improve(corners, costs, problem)
    return _completed(corners[np.argmin(costs)], problem)
