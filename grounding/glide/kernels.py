"""Compiled recursions of the semi-Markov model; equation numbers are those of docs/glide.md.

Index letters: a action, h hypothesis of its thing, s first look of a segment, e one past its last,
d = e - s. Everything is a natural logarithm relative to "all looks are background".
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from grounding.types import FloatArray, IntArray

NEVER = -1e30
Index = int | np.integer[Any]
_NEGLIGIBLE = -36.0  # exp(-36) is below the rounding of the sum


class Tables(NamedTuple):
    """The model of one session in numbers: A actions, H hypotheses, T looks, D looks at most.

    Attributes:
        kind: (A,) Kind of each action.
        in_hand: (A,) 1 where the action goes on with the hypothesis of the one before.
        is_level: (A,) 1 where the three thirds of the action have the same mixture.
        log_theta: (A, H) prior of the hypotheses where an action starts anew.
        start: (A, H, T + 1) factor of beginning with look s.
        end: (A, H, T + 1) factor of ending before look e.
        duration: (K, T, D + 1) factor of the time that d looks from s take.
        cuts: (T, D + 1, 2) where the second and the last third of a segment begin.
        looks: (A, H, 3, T + 1) cumulated log mixtures of each third.
        grid_row: (A, H) row of `grid`, or -1 where the position is that of an instance.
        grid: (G, T, D + 1) log likelihood of a segment with its position summed over the grid.
        stay: (A + 1,) log of one more background look after action a - 1.
        leave: (A + 1,) log of ending the background.
        skip: (A, T + 1) log of not doing the action at that boundary.
    """

    kind: IntArray
    in_hand: IntArray
    is_level: IntArray
    log_theta: FloatArray
    start: FloatArray
    end: FloatArray
    duration: FloatArray
    cuts: IntArray
    looks: FloatArray
    grid_row: IntArray
    grid: FloatArray
    stay: FloatArray
    leave: FloatArray
    skip: FloatArray


@njit(cache=True)
def log_add(x: float, y: float) -> float:
    """Return log(exp(x) + exp(y))."""
    if x < y:
        x, y = y, x
    return x if y - x < _NEGLIGIBLE or x < NEVER / 2 else float(x + np.log1p(np.exp(y - x)))


@njit(cache=True)
def log_sum(values: FloatArray) -> float:
    """Return the logarithm of the sum of exponentials."""
    top = values.max()
    if top <= NEVER / 2:
        return NEVER
    total = 0.0
    for v in values:
        if v - top > _NEGLIGIBLE:
            total += np.exp(v - top)
    return float(top + np.log(total))


@njit(cache=True)
def log_sum_over_things(values: FloatArray) -> FloatArray:
    """Return (T + 1,) the logarithm of the sum of exponentials over the rows of (H, T + 1)."""
    top: FloatArray = values[0].copy()
    for row in values[1:]:
        for t in range(len(top)):
            top[t] = max(top[t], row[t])
    total = np.zeros_like(top)
    for row in values:
        for t in range(len(top)):
            low = row[t] - top[t]
            if low > _NEGLIGIBLE:
                total[t] += np.exp(low)
    for t in range(len(top)):
        top[t] = NEVER if top[t] <= NEVER / 2 else top[t] + np.log(total[t])
    return top


@njit(cache=True)
def segments(tb: Tables, a: Index, h: Index, s: Index, out: FloatArray) -> int:
    """Fill out[d] with the log factor of the segment of d looks from s, eq. 11.

    Returns:
        The longest d; 0 where action a with h cannot begin there.
    """
    begin = tb.start[a, h, s]
    if begin <= NEVER / 2:
        return 0
    longest: int = min(tb.duration.shape[2] - 1, int(tb.duration.shape[1] - s))
    duration, end, row = tb.duration[tb.kind[a], s], tb.end[a, h], tb.grid_row[a, h]
    if row >= 0:
        grid = tb.grid[row, s]
        for d in range(1, longest + 1):
            out[d] = begin + duration[d] + end[s + d] + grid[d]
        return longest
    first, middle, last = tb.looks[a, h, 0], tb.looks[a, h, 1], tb.looks[a, h, 2]
    begin -= first[s]
    if tb.is_level[a]:
        for d in range(1, longest + 1):
            out[d] = begin + duration[d] + end[s + d] + first[s + d]
        return longest
    cuts = tb.cuts[s]
    for d in range(1, longest + 1):
        p, q = cuts[d, 0], cuts[d, 1]
        looks = first[p] - middle[p] + middle[q] - last[q] + last[s + d]
        out[d] = begin + duration[d] + end[s + d] + looks
    return int(longest)


@njit(cache=True)
def hypotheses(tb: Tables, a: int) -> IntArray:
    """Return the hypotheses of an action that are possible at all."""
    possible: IntArray = np.flatnonzero(tb.log_theta[a] > NEVER)
    return possible


@njit(cache=True)
def entering(tb: Tables, done: FloatArray, a: int) -> FloatArray:
    """Return (H, T + 1): log of everything before look s, when action a begins there with h."""
    before: FloatArray = done[a].copy()
    if tb.in_hand[a]:
        return before
    before_any = log_sum_over_things(done[a])
    for h in range(len(before)):
        before[h] = before_any + tb.log_theta[a, h]
    return before


@njit(cache=True)
def _background(tb: Tables, ended: FloatArray, a: int) -> FloatArray:
    """Carry "action a - 1 ended before look t" through the background after it, eq. 13."""
    done = np.empty_like(ended)
    run = NEVER
    for t in range(ended.shape[0]):
        run = log_add(run + tb.stay[a], ended[t])
        done[t] = run + tb.leave[a]
    return done


@njit(cache=True)
def _ended(tb: Tables, before: FloatArray, a: int, h: Index) -> FloatArray:
    """Return (T + 1,): log of everything before look e, where action a with h has just ended."""
    boundaries, lengths = before.shape[0], tb.duration.shape[2]
    begins = np.flatnonzero((tb.start[a, h] > NEVER / 2) & (before > NEVER / 2))
    terms = np.empty((len(begins), lengths))
    longest = np.zeros(len(begins), dtype=np.int64)
    top: FloatArray = before + tb.skip[a]
    if not len(begins):
        return top
    total = top.copy()
    for k, s in enumerate(begins):
        longest[k] = segments(tb, a, h, s, terms[k])
        for d in range(1, longest[k] + 1):
            terms[k, d] += before[s]
            top[s + d] = max(top[s + d], terms[k, d])
    for e in range(boundaries):
        total[e] = np.exp(total[e] - top[e])
    for k, s in enumerate(begins):
        for d in range(1, longest[k] + 1):
            low = terms[k, d] - top[s + d]
            if low > _NEGLIGIBLE:
                total[s + d] += np.exp(low)
    ended: FloatArray = top + np.log(total)
    return ended


@njit(cache=True)
def forward(tb: Tables) -> FloatArray:
    """Return (A + 1, H, T + 1): log of the looks before t, actions before a done, eq. 13."""
    acts, things, count = tb.log_theta.shape[0], tb.log_theta.shape[1], tb.duration.shape[1]
    done = np.full((acts + 1, things, count + 1), NEVER)
    begin = np.full(count + 1, NEVER)
    begin[0] = 0.0
    done[0, 0] = _background(tb, begin, 0)
    for a in range(acts):
        before = entering(tb, done, a)
        for h in hypotheses(tb, a):
            done[a + 1, h] = _background(tb, _ended(tb, before[h], a, h), a + 1)
    return done


@njit(cache=True)
def _background_back(tb: Tables, after: FloatArray, a: int) -> FloatArray:
    """Return (T + 1,): log of everything after action a - 1 ended before look t."""
    future = np.empty_like(after)
    run = NEVER
    for t in range(after.shape[0] - 1, -1, -1):
        run = log_add(run + tb.stay[a], after[t] + tb.leave[a])
        future[t] = run
    return future


@njit(cache=True)
def _opens(tb: Tables, future: FloatArray, a: int, h: Index) -> FloatArray:
    """Return (T + 1,): log of all looks from s on, when action a with h begins there."""
    opens: FloatArray = tb.skip[a] + future
    terms = np.empty(tb.duration.shape[2])
    for s in np.flatnonzero(tb.start[a, h] > NEVER / 2):
        terms[0] = opens[s]
        longest = segments(tb, a, h, s, terms)
        for d in range(1, longest + 1):
            terms[d] += future[s + d]
        opens[s] = log_sum(terms[: longest + 1])
    return opens


@njit(cache=True)
def backward(tb: Tables) -> FloatArray:
    """Return (A + 1, H, T + 1): log of all looks from t on, actions before a ended, eq. 14."""
    acts, things, count = tb.log_theta.shape[0], tb.log_theta.shape[1], tb.duration.shape[1]
    future = np.full((acts + 1, things, count + 1), NEVER)
    last = np.full(count + 1, NEVER)
    last[count] = 0.0
    future[acts] = _background_back(tb, last, acts)
    for a in range(acts - 1, -1, -1):
        opens = np.full((things, count + 1), NEVER)
        for h in hypotheses(tb, a):
            opens[h] = _opens(tb, future[a + 1, h], a, h)
        if tb.in_hand[a]:
            for h in hypotheses(tb, a):
                future[a, h] = _background_back(tb, opens[h], a)
            continue
        for h in range(things):
            opens[h] += tb.log_theta[a, h]
        future[a] = _background_back(tb, log_sum_over_things(opens), a)
    return future


class Marks(NamedTuple):
    """The posterior of the partition, eq. 15.

    Attributes:
        inside: (A, H, 3, T + 1) that look t lies in that third of a's segment with h; the last
            column is empty.
        begins: (A, T + 1) of the first look.
        ends: (A, T + 1) of the end.
        grids: (A, T, D + 1) of segments whose position is summed over the grid.
        things: (A, H) of the hypotheses, skipped or not.
        skipped: (A,) of not being done.
    """

    inside: FloatArray
    begins: FloatArray
    ends: FloatArray
    grids: FloatArray
    things: FloatArray
    skipped: FloatArray


def no_marks(tb: Tables) -> Marks:
    """Return marks of weight zero."""
    acts, things = tb.log_theta.shape
    _, count, lengths = tb.duration.shape
    return Marks(
        inside=np.zeros((acts, things, 3, count + 1)),
        begins=np.zeros((acts, count + 1)),
        ends=np.zeros((acts, count + 1)),
        grids=np.zeros((acts, count, lengths)),
        things=np.zeros((acts, things)),
        skipped=np.zeros(acts),
    )


@njit(cache=True)
def mark(tb: Tables, marks: Marks, where: tuple[Index, Index, Index, Index], weight: float) -> None:
    """Add one segment's weight; `inside` takes steps that `cumulate` sums up.

    Args:
        tb: the model.
        marks: changed in place.
        where: action, hypothesis, first look and end; alike for an action that was skipped.
        weight: posterior weight of the segment.
    """
    a, h, s, e = where
    marks.things[a, h] += weight
    if s == e:
        marks.skipped[a] += weight
        return
    marks.begins[a, s] += weight
    marks.ends[a, e] += weight
    if tb.grid_row[a, h] >= 0:
        marks.grids[a, s, e - s] += weight
    edges = (s, tb.cuts[s, e - s, 0], tb.cuts[s, e - s, 1], e)
    for k in range(3):
        marks.inside[a, h, k, edges[k]] += weight
        marks.inside[a, h, k, edges[k + 1]] -= weight


@njit(cache=True)
def cumulate(marks: Marks) -> None:
    """Turn the steps in `inside` into probabilities."""
    for a, h in np.argwhere(marks.things > 0.0):
        for third in marks.inside[a, h]:
            for t in range(1, len(third)):
                third[t] += third[t - 1]


@njit(cache=True)
def posterior(tb: Tables, done: FloatArray, future: FloatArray, marks: Marks) -> float:
    """Fill the marks from the two passes and return the log evidence, eq. 15."""
    acts, count = tb.log_theta.shape[0], tb.duration.shape[1]
    log_z = log_sum(done[acts, :, count])
    terms = np.empty(tb.duration.shape[2])
    for a in range(acts):
        before = entering(tb, done, a) - log_z
        for h in hypotheses(tb, a):
            skipping = before[h] + tb.skip[a] + future[a + 1, h]
            for s in np.flatnonzero(skipping > _NEGLIGIBLE):
                mark(tb, marks, (a, h, s, s), np.exp(skipping[s]))
            for s in np.flatnonzero((tb.start[a, h] > NEVER / 2) & (before[h] > NEVER / 2)):
                longest = segments(tb, a, h, s, terms)
                for d in range(1, longest + 1):
                    log_w = before[h, s] + terms[d] + future[a + 1, h, s + d]
                    if log_w > _NEGLIGIBLE:
                        mark(tb, marks, (a, h, s, s + d), np.exp(log_w))
    cumulate(marks)
    return log_z
