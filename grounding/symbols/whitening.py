"""The inner loops of densities: common spread, and the whitener of each word.

Compiled, since the matrices are so small that calls of a library cost more than what they do.
"""

from typing import Any

import numpy as np
from numba import njit

_Array = np.ndarray[Any, Any]


@njit(cache=True)
def pooled_covariances(
    scatters: _Array, own: _Array, effective: _Array, columns: _Array, weight: float
) -> _Array:
    """Return the predictive covariances (K, d, d) of words that share part of their spread.

    Args:
        scatters: (K, D, D) of the words, over all features.
        own: (K,) weights of the words' patches.
        effective: (K,) the same with correlated patches counted as such.
        columns: (d,) the features to predict.
        weight: how many patches the common spread is worth.
    """
    count, size = len(scatters), len(columns)
    covariances = np.empty((count, size, size))
    total = weight + own.sum()
    for i in range(size):
        for j in range(size):
            resolution = 1.0 if i == j else 0.0
            common = weight * resolution
            for k in range(count):
                common += scatters[k, columns[i], columns[j]]
            common /= total
            for k in range(count):
                shared = weight * common + scatters[k, columns[i], columns[j]]
                further = 1 + 1 / (1 + effective[k])
                covariances[k, i, j] = (shared / (weight + own[k]) + resolution) * further
    return covariances


@njit(cache=True)
def whitened(covariances: _Array) -> tuple[_Array, _Array]:
    """Return inverse Cholesky factors (K, d, d) of covariances, and ln of their determinants (K,).

    Raises:
        LinAlgError: if a covariance is not positive definite.
    """
    count, size = covariances.shape[:2]
    whiteners = np.zeros((count, size, size))
    log_scale = np.zeros(count)
    for k in range(count):
        lower = np.linalg.cholesky(covariances[k])
        inverse = whiteners[k]
        for i in range(size):
            for m in range(i):
                factor = lower[i, m] / lower[i, i]
                for j in range(m + 1):
                    inverse[i, j] -= factor * inverse[m, j]
            inverse[i, i] = 1 / lower[i, i]
            log_scale[k] -= np.log(lower[i, i])
    return whiteners, log_scale
