"""How typical a patch is of each word of a group."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
from scipy.special import gammaln

from grounding.features.registry import features_named
from grounding.symbols.model import Moments
from grounding.symbols.whitening import pooled_covariances, whitened
from grounding.types import FloatArray

_LIGHT_SIGMA: Final = 0.35  # of the logarithm: the light is seldom more than twice as bright


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GroupDensity:
    """The posterior predictive of each of K words over d features (Student's t).

    Attributes:
        means: (K, d).
        whiteners: (K, d, d) turn an offset from the mean into units of spread.
        log_scale: (K,) log of the determinant of each whitener.
        dof: (K,) degrees of freedom; infinite for a normal.
    """

    means: FloatArray
    whiteners: FloatArray
    log_scale: FloatArray
    dof: FloatArray

    def beside(self, other: "GroupDensity", *, dof: FloatArray) -> "GroupDensity":
        """Return the densities of both (K + L words) with other degrees of freedom."""
        return GroupDensity(
            means=np.concatenate([self.means, other.means]),
            whiteners=np.concatenate([self.whiteners, other.whiteners]),
            log_scale=np.concatenate([self.log_scale, other.log_scale]),
            dof=dof,
        )

    def squared_distances(self, samples: FloatArray) -> FloatArray:
        """Return Mahalanobis distances (N, K), squared; features that are NaN are left out."""
        if np.isfinite(samples).all():
            return self._distances_of_whole(samples)
        rows = [self._marginal(sample).squared_distances(_finite(sample)) for sample in samples]
        return np.vstack(rows)

    def log_densities(self, samples: FloatArray) -> FloatArray:
        """Return log densities (N, K)."""
        if not np.isfinite(samples).all():
            rows = [self._marginal(sample).log_densities(_finite(sample)) for sample in samples]
            return np.vstack(rows)
        return self._log_t(self._distances_of_whole(samples))

    def _distances_of_whole(self, samples: FloatArray) -> FloatArray:
        offsets = samples[None] - self.means[:, None]  # (K, N, d)
        white = offsets @ self.whiteners.transpose(0, 2, 1)
        return np.asarray(np.einsum("knd,knd->nk", white, white))

    def _log_t(self, squared: FloatArray) -> FloatArray:
        d = self.means.shape[1]
        dof = np.where(np.isfinite(self.dof), self.dof, 1.0)
        log_t = (
            gammaln((dof + d) / 2)
            - gammaln(dof / 2)
            - d / 2 * np.log(dof * np.pi)
            - (dof + d) / 2 * np.log1p(squared / dof)
        )
        log_normal = -(d * np.log(2 * np.pi) + squared) / 2
        log_densities: FloatArray = np.where(np.isfinite(self.dof), log_t, log_normal)
        return log_densities + self.log_scale

    def _marginal(self, sample: FloatArray) -> "GroupDensity":
        """Return the density over the features that a sample has."""
        has = np.flatnonzero(np.isfinite(sample))
        covariances = np.linalg.inv(np.einsum("kij,kil->kjl", self.whiteners, self.whiteners))
        return density(
            [mean[has] for mean in self.means],
            [covariance[np.ix_(has, has)] for covariance in covariances],
            self.dof,
        )


def density(
    means: Sequence[FloatArray] | FloatArray,
    covariances: Sequence[FloatArray] | FloatArray,
    dof: FloatArray,
) -> GroupDensity:
    """Return the densities of words with the given means (d,) and covariances (d, d)."""
    whiteners, log_scale = whitened(np.asarray(covariances))
    return GroupDensity(
        means=np.asarray(means),
        whiteners=whiteners,
        log_scale=log_scale,
        dof=np.asarray(dof, float),
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LightSlope:
    """How scaled features (D,) rise with the logarithm of the light: gain * (value + base)."""

    gain: FloatArray
    base: FloatArray

    @staticmethod
    def of(names: tuple[str, ...], offset: FloatArray, unit: FloatArray) -> "LightSlope":
        """Return the slope of named features that are scaled by offset and unit (D,)."""
        gain, base = _light_of(names)
        return LightSlope(gain=gain, base=(offset + base) / unit)

    def spread(self, means: FloatArray, columns: Sequence[int]) -> FloatArray:
        """Return the covariances (K, d, d) that another light adds at means (K, D)."""
        slopes: FloatArray = (_LIGHT_SIGMA * self.gain * (means + self.base))[:, columns]
        return slopes[:, :, None] * slopes[:, None, :]


@cache
def _light_of(names: tuple[str, ...]) -> tuple[FloatArray, FloatArray]:
    features = features_named(names)
    gain = np.array([feature.light_gain for feature in features])
    return gain, np.array([feature.light_base for feature in features])


def predictive(
    moments: Sequence[Moments],
    columns: Sequence[int],
    weight: float,
    light: LightSlope | None = None,
) -> GroupDensity:
    """Return the posterior predictive of words that share part of their spread.

    Each word's covariance is drawn towards the group's common one, that towards the features'
    resolution (the identity in scaled features); the resolution is then added once more, since
    the next patch may be taken under another light.

    Args:
        moments: of each word, in scaled features.
        columns: the features to predict.
        weight: how many patches the common spread is worth.
        light: for a patch under a light of another brightness; None for the same light.
    """
    means = np.array([each.mean for each in moments])  # (K, D)
    own = np.array([each.weight for each in moments])
    covariances = pooled_covariances(
        np.array([each.scatter for each in moments]),
        own,
        np.array([each.effective for each in moments]),
        np.asarray(columns),
        weight,
    )
    if light is not None:
        covariances += light.spread(means, columns)
    return density(means[:, columns], covariances, weight + own)


def _finite(sample: FloatArray) -> FloatArray:
    return sample[np.isfinite(sample)][None]
