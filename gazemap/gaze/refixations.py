"""Small saccades inside what looks like one fixation.

People look at one thing several times in a row; the eye then moves by less than the noise of a
single sample, and no velocity shows it. The means of two rests still differ clearly. A span is
cut where several rests explain it better than one. How far gaze reaches is not known exactly (a
thing stands above the table), and a wrong distance looks like drift while the head moves: the
distance is chosen with the cuts, and what drift is left counts as noise that many samples share.
Rests have a usual length: where noise hides the steps, a span of five usual lengths is hardly one.

Source:
    Optimal partitioning (Jackson et al. 2005): the cheapest cut of samples 0 .. n into segments,
    each with its least squares and a penalty, found by dynamic programming.
"""

from itertools import pairwise

import numpy as np

from gazemap.gaze.config import FixationConfig
from gazemap.gaze.steady import SteadyGaze
from gazemap.geometry.arrays import FloatArray, IntArray

_MAX_SAMPLES = 1200
_MIN_SIGMA_DEG = 0.02
_NEARER = (1.0, 0.975, 0.95, 0.925, 0.9)
_MOST_UNUSUAL = 16.0  # chi-square of the strangest duration: some looks are long


def split_refixations(span: IntArray, steady: SteadyGaze, config: FixationConfig) -> list[IntArray]:
    """Return the parts of a span (N,) of sample indices in which gaze rests."""
    least = max(4, round(config.min_duration_s / steady.period_s))
    if len(span) < 2 * least or len(span) > _MAX_SAMPLES:
        return [span]
    middle = np.full(len(span), span[len(span) // 2])
    seen_deg = [steady.seen_from(middle, span, nearer=nearer) for nearer in _NEARER]
    white = 1.4826 * np.median(np.abs(np.diff(seen_deg[0], axis=0))) / np.sqrt(2.0)
    usual_count = config.usual_duration_s / steady.period_s
    sigma = np.hypot(max(white, _MIN_SIGMA_DEG), config.drift_sigma_deg * np.sqrt(usual_count))
    penalty = 2.0 * config.split_penalty + _unusual(len(span), usual_count, config)
    tried = [_best_cuts(seen / sigma, least, penalty) for seen in seen_deg]
    _, cuts = min(tried, key=lambda costs_and_cuts: costs_and_cuts[0])
    return [span[a:b] for a, b in pairwise(cuts)]


def _unusual(count: int, usual_count: float, config: FixationConfig) -> FloatArray:
    """Return how unusual a rest of 0 .. count samples is (count + 1,), as a chi-square."""
    lengths = np.maximum(np.arange(count + 1), 1)
    z = np.log(lengths / usual_count) / config.duration_log_sigma
    return np.minimum(z**2, _MOST_UNUSUAL)


def _best_cuts(values: FloatArray, least: int, penalty: FloatArray) -> tuple[float, list[int]]:
    """Return the cost, and 0, the cuts and N, for values (N, 2) of unit noise.

    Each segment costs its squares and the penalty (N + 1,) of its length.
    """
    sums, squares = _running(values), _running((values**2).sum(axis=1))
    count = len(values)
    best = np.full(count + 1, np.inf)
    best[0] = 0.0
    last = np.zeros(count + 1, dtype=np.int64)
    for end in range(least, count + 1):
        starts = np.arange(0, end - least + 1)
        total = sums[end] - sums[starts]
        residual = squares[end] - squares[starts] - (total**2).sum(axis=1) / (end - starts)
        costs = best[starts] + residual + penalty[end - starts]
        k = int(np.argmin(costs))
        best[end], last[end] = costs[k], starts[k]
    cuts = [count]
    while cuts[-1] > 0:
        cuts.append(int(last[cuts[-1]]))
    return float(best[count]), cuts[::-1]


def _running(values: FloatArray) -> FloatArray:
    start = np.zeros((1, *values.shape[1:]))
    return np.concatenate([start, np.cumsum(values, axis=0)])
