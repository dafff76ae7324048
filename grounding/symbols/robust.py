"""Meanings from labels of which whole segments are wrong.

For a group of words, each segment's label is right or wrong as a whole. If it is right, its
patches follow the word's distribution, with a heavy tail for the stray patch; if it is wrong,
they follow one of the other words or are anything at all. Expectation and maximisation alternate:
how likely each segment is right, and the moments of each word weighted with that.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from grounding.symbols.calibration import thinned
from grounding.symbols.density import GroupDensity, LightSlope, density, predictive
from grounding.symbols.model import Moments
from grounding.symbols.records import RobustConfig
from grounding.types import FloatArray

_ITERATIONS: Final = 30
_PATIENCE: Final = 4  # iterations before a segment may be of a stranger
_CONVERGED: Final = 1e-6
_TELLING: Final = 4  # patches of a segment tell which of them is unlike
_UNLIKE: Final = 2.5  # spreads within a segment, root mean square over the features
_STRAY: Final = 0.25  # typicality below which a patch shows something else
_STRANGER: Final = 0.3  # of wrong segments that show no thing of the group
_FIRST_SPREAD: Final = 1.0  # resolutions squared
_JACKKNIFED: Final = 120  # segments that are left out in turn for the calibration
_FIRST_SEGMENTS: Final = 600
_ALIKE: Final = 4.0  # resolutions, root mean square over the group's features

Indices = NDArray[np.intp]


@dataclass(frozen=True, kw_only=True, eq=False)
class Evidence:
    """What was said of a group of K words.

    Attributes:
        samples: (N, D) scaled features.
        weights: (N,) of the patches.
        segment: (N,) index of each patch's segment.
        label: (S,) index of the word that each segment bears.
        word_count: K.
        columns: the group's features.
        anything: moments of all patches whatever was said.
        light: how features change with the light.
    """

    samples: FloatArray
    weights: FloatArray
    segment: Indices
    label: Indices
    word_count: int
    columns: list[int]
    anything: Moments
    light: LightSlope

    @cached_property
    def alike(self) -> FloatArray:
        """(N,) weight of each patch beside the others of its segment: 1, less where it is unlike.

        A segment shows one thing, so the patch that differs from most of its segment shows
        something else, a bare table say, however wide the word is.
        """
        chosen = self.samples[:, self.columns]
        weight = np.ones(len(chosen))
        for segment in np.unique(self.segment):
            rows = np.flatnonzero(self.segment == segment)
            if len(rows) < _TELLING:
                continue
            off = np.abs(chosen[rows] - np.median(chosen[rows], axis=0))
            spread = np.maximum(1.0, 1.5 * np.median(off, axis=0))
            apart = np.sqrt(np.mean((off / spread) ** 2, axis=1))
            weight[rows] = np.minimum(1.0, (_UNLIKE / np.maximum(apart, 1e-9)) ** 4)
        return weight


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Belief:
    """What is believed of the evidence.

    Attributes:
        right: (S,) probability that a segment's label is right.
        typical: (N,) how typical each patch is of its word: 1, less for a stray one.
        moments: of each word.
    """

    right: FloatArray
    typical: FloatArray
    moments: list[Moments]


def learn_words(evidence: Evidence, config: RobustConfig, *, strangers: bool) -> Belief:
    """Return what the words of a group mean.

    Args:
        evidence: what was said.
        config: the noise model.
        strangers: whether a segment may show no thing of the group; with too little known to
            say what the words describe, nothing is strange.
    """
    words = _first_guess(evidence, config)
    wrong_rate, before = config.wrong_rate, np.zeros(len(evidence.label))
    for turn in range(_ITERATIONS):
        belief = believe(
            evidence, words, config, wrong_rate, strangers=strangers and turn >= _PATIENCE
        )
        words = predictive(belief.moments, evidence.columns, config.covariance_weight)
        wrong = float((1 - belief.right).sum()) + config.wrong_rate * config.wrong_rate_weight
        wrong_rate = min(0.5, wrong / (len(belief.right) + config.wrong_rate_weight))
        if turn > _PATIENCE and np.abs(belief.right - before).max() < _CONVERGED:
            break
        before = belief.right
    return believe(evidence, words, config, wrong_rate, strangers=strangers)


def believe(
    evidence: Evidence,
    words: GroupDensity,
    config: RobustConfig,
    wrong_rate: float,
    *,
    strangers: bool,
) -> Belief:
    """Return one step's belief: responsibilities first, moments after.

    Args:
        evidence: what was said.
        words: what the words mean so far.
        config: the noise model.
        wrong_rate: how many labels are wrong so far.
        strangers: whether a segment may show no thing of the group. Not before the words have
            found their spread: until then everything looks strange.
    """
    own = evidence.label[evidence.segment]  # (N,)
    counts = _per_segment(np.ones(len(own)), evidence)
    temper = np.array([tempering(count, config) for count in counts.tolist()])
    chosen = evidence.samples[:, evidence.columns]
    squared = words.squared_distances(chosen)
    logs = patch_logs(chosen, words, evidence.columns, evidence.anything, config)
    if not strangers:
        logs[:, -1] = logs[:, 0] if logs.shape[1] == 2 else -np.inf
    totals = np.column_stack(
        [_per_segment(column * evidence.weights * evidence.alike, evidence) for column in logs.T]
    )
    right = label_right(label_log_odds(totals * temper[:, None], evidence.label), wrong_rate)
    typical = typicality(squared[np.arange(len(own)), own], chosen.shape[1], config)
    influence = influence_of(typical) if strangers else typical
    typical = typical * evidence.alike
    weights = right[evidence.segment] * evidence.weights * influence * evidence.alike
    moments = [
        Moments.of(
            evidence.samples,
            np.where(own == word, weights, 0.0),
            effective=float((weights * temper[evidence.segment])[own == word].sum()),
        )
        for word in range(len(words.means))
    ]
    return Belief(right=right, typical=typical, moments=moments)


def known_distances(evidence: Evidence, belief: Belief, config: RobustConfig) -> FloatArray:
    """Return distances of believed patches from their words, each segment left out in turn."""
    believed = np.flatnonzero(belief.right > 0.5)
    step = -(-len(believed) // _JACKKNIFED)
    found = [np.empty(0)]
    for segment in believed[:: max(1, step)]:
        inside = evidence.segment == segment
        word = int(evidence.label[segment])
        influence = influence_of(belief.typical[inside])
        weights = evidence.weights[inside] * influence * belief.right[segment]
        weights *= evidence.alike[inside]
        count = int(np.count_nonzero(inside))
        temper = tempering(count, config)
        own = Moments.of(evidence.samples[inside], weights, effective=float(weights.sum()) * temper)
        others = list(belief.moments)
        others[word] = others[word].plus(own.scaled(-1.0))
        if others[word].weight <= 0:
            continue
        words = predictive(others, evidence.columns, config.covariance_weight, evidence.light)
        typical = inside & (belief.typical > 0.5)
        chosen = evidence.samples[np.ix_(typical, evidence.columns)]
        found.append(np.sqrt(words.squared_distances(chosen)[:, word]))
    return thinned(np.concatenate(found))


def patch_logs(
    chosen: FloatArray,
    words: GroupDensity,
    columns: list[int],
    anything: Moments,
    config: RobustConfig,
) -> FloatArray:
    """Return log likelihoods (N, K + 1) of patches under each word, and last under anything.

    Args:
        chosen: (N, d) the group's features.
        words: the group's densities.
        columns: the group's features among all.
        anything: moments of all patches.
        config: the noise model.
    """
    grid = np.ix_(columns, columns)
    spread = anything.scatter[grid] / max(anything.weight, 1.0) + np.eye(len(columns))
    wide = density([anything.mean[columns]], [spread], np.array([config.tail_dof]))
    dof = np.full(len(words.means) + 1, config.tail_dof)
    return words.beside(wide, dof=dof).log_densities(chosen)


def tempering(patches: float, config: RobustConfig) -> float:
    """Return what one of so many patches of a segment counts, correlated as they are."""
    return 1 / (1 + (patches - 1) * config.segment_correlation)


def typicality(squared: FloatArray, dimension: int, config: RobustConfig) -> FloatArray:
    """Return the weight of patches at squared distances: 1, less for a stray one."""
    weight = (config.tail_dof + dimension) / (config.tail_dof + squared)
    return np.minimum(1.0, weight)


def influence_of(typical: FloatArray) -> FloatArray:
    """Return what patches count for a word's moments, from how typical they are.

    As much as they are typical, but what is no such thing at all counts for nothing: a bare table
    in a right segment must not widen the word, however far off it is.
    """
    return typical * np.minimum(1.0, (typical / _STRAY) ** 2)


def label_log_odds(totals: FloatArray, label: Indices) -> FloatArray:
    """Return the log odds (S,) that each label is right, without the prior.

    Args:
        totals: (S, K + 1) log likelihood of each segment under each word, last under anything.
        label: (S,) the word that was said.
    """
    at = np.arange(len(label))
    others = totals.shape[1] - 2
    prior = np.full(totals.shape, np.log((1 - _STRANGER) / max(others, 1)))
    prior[:, -1] = np.log(_STRANGER) if others else 0.0
    prior[at, label] = -np.inf
    otherwise = totals + prior
    most = otherwise.max(axis=1, keepdims=True)
    log_sum = most[:, 0] + np.log(np.exp(otherwise - most).sum(axis=1))
    log_odds: FloatArray = totals[at, label] - log_sum
    return log_odds


def label_right(log_odds: FloatArray, wrong_rate: float) -> FloatArray:
    """Return the probability (S,) that a label is right when so many are wrong."""
    probability: FloatArray = expit(log_odds + np.log1p(-wrong_rate) - np.log(wrong_rate))
    return probability


def _per_segment(values: FloatArray, evidence: Evidence) -> FloatArray:
    sums = np.bincount(evidence.segment, weights=values, minlength=len(evidence.label))
    return np.asarray(sums, float)


def _first_guess(evidence: Evidence, config: RobustConfig) -> GroupDensity:
    """Return words centred on the segment that most others of the word, and few else, resemble.

    Words of a group exclude each other, so where many wrong segments of a word look alike, they
    look like another word's right ones.
    """
    chosen = evidence.samples[:, evidence.columns]
    segments = np.arange(len(evidence.label))
    segments = segments[:: -(-len(segments) // _FIRST_SEGMENTS)]
    centres = np.array([np.median(chosen[evidence.segment == s], axis=0) for s in segments])
    squares = np.sum(centres**2, axis=1)
    squared = np.maximum(squares[:, None] + squares - 2 * centres @ centres.T, 0)
    alike = np.exp(-squared / centres.shape[1] / (2 * _ALIKE**2))  # (S, S)
    label = evidence.label[segments]
    means = []
    for word in range(evidence.word_count):
        merit = alike[:, label == word].sum(axis=1) ** 2 / alike.sum(axis=1)
        means.append(centres[np.argmax(np.where(label == word, merit, -1.0))])
    spread = [_FIRST_SPREAD * np.eye(centres.shape[1])] * len(means)
    return density(means, spread, np.full(len(means), config.tail_dof))
