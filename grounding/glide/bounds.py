"""Rule out segments that no likely explanation uses, so that the exact sums run over few.

A backward pass with maxima in place of sums gives the best explanation from every beginning of a
segment on; a forward pass adds what came before. Beginnings worse than the very best by more than
`_HOPELESS` add less than rounding to any posterior; the forward pass leaves them out already. The
inner loops run along memory, so that the compiler takes several lengths at once.
"""

import numpy as np
from numba import njit

from grounding.glide.kernels import NEVER, Index, Tables, hypotheses
from grounding.types import FloatArray

_HOPELESS = 60.0  # e^-60 times the number of segments is below the rounding of a sum of order 1


def pruned(tables: Tables) -> Tables:
    """Return the tables with the hopeless beginnings ruled out."""
    return tables._replace(start=_hopeful_starts(tables))


@njit(cache=True)
def _hopeful_starts(tb: Tables) -> FloatArray:
    acts, things = tb.log_theta.shape
    count = tb.duration.shape[1]
    through, bound = _best_backward(tb)
    start = np.full(tb.start.shape, NEVER)
    best = np.full((things, count + 1), NEVER)
    best[0] = np.arange(count + 1) * tb.stay[0] + tb.leave[0]
    for a in range(acts):
        into = _into(tb, best, a)
        best[:] = NEVER
        for h in hypotheses(tb, a):
            hopeful = into[h] + through[a, h] > bound
            start[a, h] = np.where(hopeful, tb.start[a, h], NEVER)
            ended = _best_ended(tb, np.where(hopeful, into[h], NEVER), a, h)
            ended = np.maximum(ended, into[h] + tb.skip[a])
            run = NEVER
            for t in range(count + 1):
                run = max(run + tb.stay[a + 1], ended[t])
                best[h, t] = run + tb.leave[a + 1]
    return start


@njit(cache=True)
def _best_backward(tb: Tables) -> tuple[FloatArray, float]:
    """Return the best log from each beginning on (A, H, T + 1), and what is hopeless."""
    acts, things = tb.log_theta.shape
    count = tb.duration.shape[1]
    through = np.full((acts, things, count + 1), NEVER)
    future = np.full((things, count + 1), NEVER)
    future[:] = np.arange(count, -1, -1) * tb.stay[acts] + tb.leave[acts]
    for a in range(acts - 1, -1, -1):
        opens = np.full((things, count + 1), NEVER)
        for h in hypotheses(tb, a):
            through[a, h] = _best_opens(tb, future[h], a, h)
            opens[h] = np.maximum(through[a, h], tb.skip[a] + future[h])
        future = _future(tb, opens, a)
    return through, float(future[0, 0]) - _HOPELESS


@njit(cache=True)
def _into(tb: Tables, best: FloatArray, a: int) -> FloatArray:
    """Return (H, T + 1): the best log of everything before look s, where a begins with h."""
    into: FloatArray = best.copy()
    if not tb.in_hand[a]:
        top = _best_of_things(best)
        for h in range(len(into)):
            into[h] = top + tb.log_theta[a, h]
    return into


@njit(cache=True)
def _best_of_things(values: FloatArray) -> FloatArray:
    """Return (T + 1,) the greatest of the rows of (H, T + 1)."""
    top: FloatArray = values[0].copy()
    for row in values[1:]:
        for t in range(len(top)):
            top[t] = max(top[t], row[t])
    return top


@njit(cache=True)
def _future(tb: Tables, opens: FloatArray, a: int) -> FloatArray:
    """Return (H, T + 1): the best log of everything from look t on, where a - 1 ended there."""
    after = opens.copy()
    if not tb.in_hand[a]:
        for h in range(len(after)):
            after[h] += tb.log_theta[a, h]
        after[:] = _best_of_things(after)
    for h in range(after.shape[0]):
        run = NEVER
        for t in range(after.shape[1] - 1, -1, -1):
            run = max(run + tb.stay[a], after[h, t] + tb.leave[a])
            after[h, t] = run
    return after


@njit(cache=True)
def _lasting(tb: Tables, a: int, h: Index, s: Index) -> FloatArray:
    """Return (D' + 1,): log of d looks from s, without what depends on s or the end alone."""
    reach = min(tb.duration.shape[2], tb.duration.shape[1] - s + 1)
    lasts: FloatArray = tb.duration[tb.kind[a], s, :reach]
    row = tb.grid_row[a, h]
    if row >= 0:
        return lasts + tb.grid[row, s, :reach]
    if tb.is_level[a]:
        return lasts
    looks, cuts, out = tb.looks[a, h], tb.cuts[s], lasts.copy()
    for d in range(1, reach):
        p, q = cuts[d, 0], cuts[d, 1]
        out[d] += looks[0, p] - looks[1, p] + looks[1, q] - looks[2, q]
    return out


@njit(cache=True)
def _ending(tb: Tables, a: int, h: Index) -> FloatArray:
    """Return (T + 1,): what of a segment's log depends on its end alone."""
    end: FloatArray = tb.end[a, h]
    return end if tb.grid_row[a, h] >= 0 else end + tb.looks[a, h, 2]


@njit(cache=True)
def _beginning(tb: Tables, a: int, h: Index) -> FloatArray:
    """Return (T + 1,): what of a segment's log depends on its first look alone."""
    start: FloatArray = tb.start[a, h]
    return start if tb.grid_row[a, h] >= 0 else start - tb.looks[a, h, 0]


@njit(cache=True)
def _best_ended(tb: Tables, into: FloatArray, a: int, h: Index) -> FloatArray:
    """Return (T + 1,): the best log where action a with h ends before look e."""
    begin = into + _beginning(tb, a, h)
    ended = np.full(len(begin), NEVER)
    for s in np.flatnonzero(begin > NEVER / 2):
        lasts = _lasting(tb, a, h, s)
        out = ended[s : s + len(lasts)]
        for d in range(1, len(lasts)):
            out[d] = max(out[d], begin[s] + lasts[d])
    best: FloatArray = ended + _ending(tb, a, h)
    return best


@njit(cache=True)
def _best_opens(tb: Tables, future: FloatArray, a: int, h: Index) -> FloatArray:
    """Return (T + 1,): the best log of the looks from s on, where action a with h begins."""
    begin, after = _beginning(tb, a, h), future + _ending(tb, a, h)
    opens = np.full(len(begin), NEVER)
    for s in np.flatnonzero(begin > NEVER / 2):
        lasts = _lasting(tb, a, h, s)
        then = after[s : s + len(lasts)]
        top = NEVER
        for d in range(1, len(lasts)):
            top = max(top, lasts[d] + then[d])
        opens[s] = top + begin[s]
    return opens
