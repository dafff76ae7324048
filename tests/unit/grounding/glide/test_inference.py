"""Both inferences against brute-force enumeration of every partition and every hypothesis."""

import itertools
from collections.abc import Iterator

import numpy as np
import pytest

from grounding.glide.bounds import pruned
from grounding.glide.dirichlet import partition_logs
from grounding.glide.kernels import (
    Tables,
    backward,
    forward,
    no_marks,
    posterior,
    segments,
)
from grounding.glide.viterbi import viterbi

ACTS, THINGS, LOOKS, LONGEST = 3, 3, 5, 4
IN_HAND = (0, 1, 0)


def tables(seed: int) -> Tables:
    """A model with random factors, one row of it on the grid, all thirds apart."""
    rng = np.random.default_rng(seed)
    cuts = np.zeros((LOOKS, LONGEST + 1, 2), dtype=np.int64)
    for s, d in itertools.product(range(LOOKS), range(LONGEST + 1)):
        cuts[s, d] = np.minimum([s + d // 3, s + 2 * d // 3], LOOKS)
    grid_row = np.full((ACTS, THINGS), -1, dtype=np.int64)
    grid_row[:, -1] = 0
    looks = np.zeros((ACTS, THINGS, 3, LOOKS + 1))
    looks[..., 1:] = np.cumsum(rng.normal(0, 3, (ACTS, THINGS, 3, LOOKS)), axis=3)
    return Tables(
        kind=np.array([0, 1, 2], dtype=np.int64),
        in_hand=np.array(IN_HAND, dtype=np.int64),
        is_level=np.zeros(ACTS, dtype=np.int64),
        log_theta=np.log(rng.dirichlet(np.ones(THINGS), size=ACTS)),
        start=rng.normal(0, 1, (ACTS, THINGS, LOOKS + 1)),
        end=rng.normal(0, 1, (ACTS, THINGS, LOOKS + 1)),
        duration=rng.normal(0, 1, (3, LOOKS, LONGEST + 1)),
        cuts=cuts,
        looks=looks,
        grid_row=grid_row,
        grid=rng.normal(0, 3, (1, LOOKS, LONGEST + 1)),
        stay=np.log(rng.uniform(0.2, 0.8, ACTS + 1)),
        leave=np.log(rng.uniform(0.2, 0.8, ACTS + 1)),
        skip=np.log(rng.uniform(0.05, 0.5, (ACTS, LOOKS + 1))),
    )


def segment_log(tb: Tables, a: int, h: int, s: int, e: int) -> float:
    """The factor of one segment, written out from its definition."""
    if s == e:
        return float(tb.skip[a, s])
    d = e - s
    log = tb.start[a, h, s] + tb.end[a, h, e] + tb.duration[tb.kind[a], s, d]
    if tb.grid_row[a, h] >= 0:
        return float(log + tb.grid[tb.grid_row[a, h], s, d])
    p, q = tb.cuts[s, d]
    edges = [(0, s, p), (1, p, q), (2, q, e)]
    return float(log + sum(tb.looks[a, h, k, y] - tb.looks[a, h, k, x] for k, x, y in edges))


def partitions() -> Iterator[tuple[tuple[int, int], ...]]:
    """Every way to give three actions a segment of at most LONGEST looks, or none."""
    for edges in itertools.combinations_with_replacement(range(LOOKS + 1), 2 * ACTS):
        bounds = tuple(zip(edges[0::2], edges[1::2], strict=True))
        if all(e - s <= LONGEST for s, e in bounds):
            yield bounds


def things_of(h: tuple[int, int]) -> tuple[int, int, int]:
    """The second action goes on with the thing of the first."""
    return (h[0], h[0], h[1])


def explanations(tb: Tables) -> dict[tuple[tuple[tuple[int, int], ...], tuple[int, int]], float]:
    """The log weight of every partition with every hypothesis."""
    weights = {}
    for bounds in partitions():
        ends = [0, *(e for _, e in bounds)]
        begins = [*(s for s, _ in bounds), LOOKS]
        gaps = zip(tb.stay, tb.leave, begins, ends, strict=True)
        idle = sum(float(stay * (s - e) + leave) for stay, leave, s, e in gaps)
        for h in itertools.product(range(THINGS), repeat=2):
            named = tb.log_theta[0, h[0]] + tb.log_theta[2, h[1]]
            acts = (segment_log(tb, a, things_of(h)[a], *bounds[a]) for a in range(ACTS))
            weights[bounds, h] = idle + float(named) + sum(acts)
    return weights


@pytest.fixture(params=range(4))
def model(request: pytest.FixtureRequest) -> Tables:
    return tables(int(request.param))


def test_evidence_and_posterior_equal_the_enumeration(model: Tables) -> None:
    weights = explanations(model)
    log_z = np.logaddexp.reduce(list(weights.values()))
    things, skipped = np.zeros((ACTS, THINGS)), np.zeros(ACTS)
    inside = np.zeros((ACTS, LOOKS))
    for (bounds, h), log in weights.items():
        share = np.exp(log - log_z)
        for a, (s, e) in enumerate(bounds):
            things[a, things_of(h)[a]] += share
            skipped[a] += share * (s == e)
            inside[a, s:e] += share
    marks = no_marks(model)
    evidence = posterior(model, forward(model), backward(model), marks)
    assert abs(evidence - log_z) < 1e-9
    assert np.abs(marks.things - things).max() < 1e-9
    assert np.abs(marks.skipped - skipped).max() < 1e-9
    assert np.abs(marks.inside.sum(axis=(1, 2))[:, :LOOKS] - inside).max() < 1e-9


def test_viterbi_finds_the_best_explanation(model: Tables) -> None:
    weights = explanations(model)
    bounds, h = max(weights, key=lambda each: weights[each])
    first, past, things = viterbi(model)
    assert tuple(zip(first, past, strict=True)) == bounds
    assert tuple(things) == things_of(h)


def test_sampled_partitions_weigh_what_the_enumeration_says(model: Tables) -> None:
    every = list(partitions())
    logs = partition_logs(model, np.array(every).transpose(0, 2, 1).copy())
    for bounds, log in zip(every, logs, strict=True):
        total = []
        for h in itertools.product(range(THINGS), repeat=2):
            named = float(model.log_theta[0, h[0]] + model.log_theta[2, h[1]])
            acts = (segment_log(model, a, things_of(h)[a], *bounds[a]) for a in range(ACTS))
            total.append(named + sum(acts))
        assert abs(log - np.logaddexp.reduce(total)) < 1e-9


def test_ruling_out_hopeless_segments_changes_nothing(model: Tables) -> None:
    model.looks[0, 1, :, 2:] -= 200.0  # one hypothesis becomes hopeless from the third look on
    whole = posterior(model, forward(model), backward(model), no_marks(model))
    fewer = pruned(model)
    assert np.count_nonzero(fewer.start < -1e20) > 0
    part = posterior(fewer, forward(fewer), backward(fewer), no_marks(fewer))
    assert abs(whole - part) < 1e-9


def test_a_segment_has_the_factor_of_its_definition(model: Tables) -> None:
    out = np.empty(LONGEST + 1)
    for a, h, s in itertools.product(range(ACTS), range(THINGS), range(LOOKS)):
        longest = segments(model, a, h, s, out)
        assert longest == min(LONGEST, LOOKS - s)
        for d in range(1, longest + 1):
            assert abs(out[d] - segment_log(model, a, h, s, s + d)) < 1e-12
