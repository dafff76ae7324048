"""Small saccades inside what looks like one fixation.

People look at one thing several times in a row; the eye then moves by less than the noise of a
single sample, and no velocity shows it. The means of two rests still differ clearly. A span is
cut where several rests explain it better than one. How far gaze reaches is not known exactly (a
thing stands above the table), and a wrong distance looks like drift while the head moves: each
rest has a distance of its own, near what is usual. Rests have a usual length: where noise hides
the steps, a span of five usual lengths is hardly one. Time without samples inside a span (a
blink) counts as time, not as evidence.

Source:
    Optimal partitioning (Jackson et al. 2005): the cheapest cut of samples 0 .. n into segments,
    each with its least squares and a penalty, found by dynamic programming. A rest's unknown
    distance has a Gaussian prior and is integrated out.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from gazemap.gaze.config import FixationConfig
from gazemap.gaze.steady import SteadyGaze
from gazemap.geometry.arrays import FloatArray, IntArray

_MAX_SAMPLES = 1200
_LEAST_SAMPLES = 3
_MIN_SIGMA_DEG = 0.02
_BLOCK_S = 0.08  # noise matters as it is in the mean of so long
_NEARER, _NEARER_STEP, _NEARER_SIGMA = 0.95, 0.1, 0.35  # reach; sigma is in steps
_MOST_UNUSUAL = 16.0  # chi-square of the strangest duration: some looks are long


def split_refixations(
    span: IntArray, steady: SteadyGaze, sigma_deg: float, config: FixationConfig
) -> list[IntArray]:
    """Return the parts of a span (N,) of sample indices in which gaze rests.

    `sigma_deg` is the noise of a sample as `noise_in_rests_deg` finds it.
    """
    t_s = (steady.t_ns[span] - steady.t_ns[span[0]]) * 1e-9
    if t_s[-1] < 2 * config.min_duration_s or len(span) > _MAX_SAMPLES:
        return [span]
    middle = np.full(len(span), span[len(span) // 2])
    seen_deg = steady.seen_from(middle, span, nearer=_NEARER)
    drift_deg = steady.seen_from(middle, span, nearer=_NEARER - _NEARER_STEP) - seen_deg
    if not drift_deg.any():
        usual_count = config.usual_duration_s / steady.period_s
        sigma_deg = float(np.hypot(sigma_deg, config.drift_sigma_deg * np.sqrt(usual_count)))
    rests = _Rests(seen_deg / sigma_deg, drift_deg / sigma_deg)
    cuts = _best_cuts(rests, t_s, steady.period_s, config)
    return [span[a:b] for a, b in pairwise(cuts)]


def noise_in_rests_deg(spans: Sequence[IntArray], steady: SteadyGaze) -> float:
    """Return the noise of one sample and axis, as means of many samples still show it.

    White noise alone would make means far better than they are where gaze drifts; the larger of
    the two estimates, from neighbouring samples and from neighbouring means, is taken.
    """
    count = max(1, round(_BLOCK_S / steady.period_s))
    fine, coarse = [np.empty(0)], [np.empty(0)]
    for span in spans:
        blocks = len(span) // count
        if blocks < 2:
            continue
        middle = np.full(len(span), span[len(span) // 2])
        seen_deg = steady.seen_from(middle, span, nearer=_NEARER)
        means = seen_deg[: blocks * count].reshape(blocks, count, 2).mean(axis=1)
        fine.append(np.abs(np.diff(seen_deg, axis=0)).ravel())
        coarse.append(np.abs(np.diff(means, axis=0)).ravel())
    steps = (np.concatenate(fine), np.sqrt(count) * np.concatenate(coarse))
    sigmas = [1.4826 * np.median(step) / np.sqrt(2.0) for step in steps if len(step)]
    return float(max(sigmas, default=0.0)) or _MIN_SIGMA_DEG


class _Rests:
    """Samples of unit noise, summed up so that each rest's misfit costs the same to find."""

    def __init__(self, seen: FloatArray, drift: FloatArray) -> None:
        """Take directions (N, 2) and how they shift (N, 2) with gaze a step nearer."""
        self.count = len(seen)
        self._seen, self._drift = _running(seen), _running(drift)
        self._seen_seen = _running((seen * seen).sum(axis=1))
        self._drift_drift = _running((drift * drift).sum(axis=1))
        self._seen_drift = _running((seen * drift).sum(axis=1))

    def misfits(self, starts: IntArray, end: int) -> FloatArray:
        """Return the chi-squares (M,) of samples `starts` (M,) .. `end` as one rest each."""
        seen, drift = self._seen[end] - self._seen[starts], self._drift[end] - self._drift[starts]

        def about_means(running: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
            return np.asarray(running[end] - running[starts] - (a * b).sum(1) / (end - starts))

        residual = about_means(self._seen_seen, seen, seen)
        known = np.maximum(about_means(self._drift_drift, drift, drift), 0.0)
        both = about_means(self._seen_drift, seen, drift)
        prior = 1.0 / _NEARER_SIGMA**2
        return np.asarray(residual - both**2 / (known + prior) + np.log1p(known / prior))


def _best_cuts(
    rests: _Rests, t_s: FloatArray, period_s: float, config: FixationConfig
) -> list[int]:
    """Return 0, the cuts and N; each rest costs its misfit and how unusual its length is."""
    best = np.full(rests.count + 1, np.inf)
    best[0] = 0.0
    last = np.zeros(rests.count + 1, dtype=np.int64)
    for end in range(_LEAST_SAMPLES, rests.count + 1):
        lasts_s = t_s[end - 1] + period_s - t_s[: end - _LEAST_SAMPLES + 1]
        starts = np.flatnonzero(lasts_s >= config.min_duration_s)
        if len(starts) == 0:
            continue
        costs = best[starts] + rests.misfits(starts, end) + _unusual(lasts_s[starts], config)
        k = int(np.argmin(costs))
        best[end], last[end] = costs[k] + 2.0 * config.split_penalty, starts[k]
    cuts = [rests.count]
    while cuts[-1] > 0:
        cuts.append(int(last[cuts[-1]]))
    return cuts[::-1]


def _unusual(lasts_s: FloatArray, config: FixationConfig) -> FloatArray:
    """Return how unusual rests of such lengths are (M,), as a chi-square."""
    z = np.log(lasts_s / config.usual_duration_s) / config.duration_log_sigma
    return np.asarray(np.minimum(z**2, _MOST_UNUSUAL))


def _running(values: FloatArray) -> FloatArray:
    start = np.zeros((1, *values.shape[1:]))
    return np.concatenate([start, np.cumsum(values, axis=0)])
