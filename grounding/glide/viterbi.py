"""The single best explanation of a session: the recursions of `kernels` with maxima, eq. 16."""

import numpy as np
from numba import njit

from grounding.glide.kernels import NEVER, Index, Tables, hypotheses, segments
from grounding.types import FloatArray, IntArray


@njit(cache=True)
def _best_ended(tb: Tables, into: FloatArray, a: int, h: Index) -> tuple[FloatArray, IntArray]:
    """Return (T + 1,) the best log where action a has just ended, and the length it then has."""
    best, length = into + tb.skip[a], np.zeros(into.shape[0], dtype=np.int64)
    terms = np.empty(tb.duration.shape[2])
    for s in np.flatnonzero((tb.start[a, h] > NEVER / 2) & (into > NEVER / 2)):
        longest = segments(tb, a, h, s, terms)
        for d in range(1, longest + 1):
            if into[s] + terms[d] > best[s + d]:
                best[s + d], length[s + d] = into[s] + terms[d], d
    return best, length


@njit(cache=True)
def _best_background(tb: Tables, ended: FloatArray, a: int) -> tuple[FloatArray, IntArray]:
    """Return (T + 1,) the best log after the background, and where that began."""
    best, began = np.empty_like(ended), np.zeros(ended.shape[0], dtype=np.int64)
    run, origin = NEVER, 0
    for t in range(ended.shape[0]):
        run += tb.stay[a]
        if ended[t] >= run:
            run, origin = ended[t], t
        best[t], began[t] = run + tb.leave[a], origin
    return best, began


@njit(cache=True)
def viterbi(tb: Tables) -> tuple[IntArray, IntArray, IntArray]:
    """Return the single best explanation: first look, end and hypothesis of each action, eq. 16.

    A skipped action has first look and end alike.
    """
    acts, things, count = tb.log_theta.shape[0], tb.log_theta.shape[1], tb.duration.shape[1]
    best = np.full((acts + 1, things, count + 1), NEVER)
    began = np.zeros((acts + 1, things, count + 1), dtype=np.int64)
    length = np.zeros((acts, things, count + 1), dtype=np.int64)
    begin = np.full(count + 1, NEVER)
    begin[0] = 0.0
    best[0, 0], began[0, 0] = _best_background(tb, begin, 0)
    for a in range(acts):
        into = best[a].copy()
        if not tb.in_hand[a]:
            for s in range(count + 1):
                into[:, s] = best[a, :, s].max() + tb.log_theta[a]
        for h in hypotheses(tb, a):
            ended, length[a, h] = _best_ended(tb, into[h], a, h)
            best[a + 1, h], began[a + 1, h] = _best_background(tb, ended, a + 1)
    return _trace(tb, best, began, length)


@njit(cache=True)
def _trace(
    tb: Tables, best: FloatArray, began: IntArray, length: IntArray
) -> tuple[IntArray, IntArray, IntArray]:
    acts, count = tb.log_theta.shape[0], tb.duration.shape[1]
    firsts, pasts = np.zeros(acts, dtype=np.int64), np.zeros(acts, dtype=np.int64)
    chosen = np.zeros(acts, dtype=np.int64)
    t, h = count, -1
    for a in range(acts - 1, -1, -1):
        if h < 0:
            h = int(best[a + 1, :, t].argmax())
        e = began[a + 1, h, t]
        firsts[a], pasts[a], chosen[a] = e - length[a, h, e], e, h
        t = int(firsts[a])
        if not tb.in_hand[a]:
            h = -1
    return firsts, pasts, chosen
