"""Whitening and pooling of covariances, against what they are defined by."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grounding.symbols.whitening import pooled_covariances, whitened


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 4), size=st.integers(1, 30))
def test_whitener_turns_its_covariance_into_the_identity(seed: int, count: int, size: int) -> None:
    factors = np.random.default_rng(seed).normal(size=(count, size, size))
    covariances = factors @ factors.transpose(0, 2, 1) + 0.1 * np.eye(size)
    whiteners, log_scale = whitened(covariances)
    white = whiteners @ covariances @ whiteners.transpose(0, 2, 1)
    np.testing.assert_allclose(white, np.broadcast_to(np.eye(size), white.shape), atol=1e-9)
    np.testing.assert_allclose(log_scale, -np.linalg.slogdet(covariances)[1] / 2, atol=1e-9)
    np.testing.assert_array_equal(np.triu(whiteners, 1), 0.0)


def test_a_spread_that_is_none_is_refused() -> None:
    with pytest.raises(np.linalg.LinAlgError):
        whitened(np.array([[[1.0, 2.0], [2.0, 1.0]]]))


def test_words_share_part_of_their_spread() -> None:
    rng = np.random.default_rng(3)
    factors = rng.normal(size=(3, 5, 5))
    scatters = factors @ factors.transpose(0, 2, 1)
    own, effective, columns, weight = (
        np.array([2.0, 7.0, 0.5]),
        np.array([1.0, 3.0, 0.5]),
        [0, 3],
        5,
    )
    grid = np.ix_([0, 1, 2], columns, columns)
    common = (weight * np.eye(2) + scatters[grid].sum(axis=0)) / (weight + own.sum())
    for k, covariance in enumerate(
        pooled_covariances(scatters, own, effective, np.array(columns), float(weight))
    ):
        posterior = (weight * common + scatters[grid][k]) / (weight + own[k])
        expected = (posterior + np.eye(2)) * (1 + 1 / (1 + effective[k]))
        np.testing.assert_allclose(covariance, expected, rtol=1e-12)
