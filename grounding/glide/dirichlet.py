"""Inference as in the paper: Dirichlet samples of the partition, each weighted by its likelihood.

The proportions of the 2 A + 1 segments (background, action, ..., background) of the session's time
are drawn from a Dirichlet distribution; its parameters are the expected durations times a strength.
A sample's weight is the likelihood of the looks under its partition, hypotheses summed out, eq. 24.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from grounding.glide.config import GlideConfig
from grounding.glide.exact import Beliefs, Occupancy, read_looks
from grounding.glide.kernels import (
    NEVER,
    Marks,
    Tables,
    cumulate,
    hypotheses,
    log_sum,
    mark,
    no_marks,
    segments,
)
from grounding.glide.model import Parameters, Session
from grounding.glide.tables import Model
from grounding.types import FloatArray, IntArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sampled:
    """What sampling gives.

    Attributes:
        beliefs: the importance-weighted posterior.
        effective_samples: 1 / sum of squared weights; near 1 the posterior is one lucky sample.
    """

    beliefs: Beliefs
    effective_samples: float


def infer_sampled(
    session: Session,
    model: Model,
    parameters: Parameters,
    config: GlideConfig,
    *,
    rng: np.random.Generator,
) -> Sampled:
    """Return the posterior from `config.samples` Dirichlet samples of the partition.

    Args:
        session: at least one act and one look.
        model: its factors; those of durations and gaps are replaced by the Dirichlet prior.
        parameters: whose expected durations inform the prior.
        config: number of samples and strength of the prior.
        rng: the source of chance.

    Returns:
        The beliefs, and how many samples they effectively rest on.
    """
    tables = without_durations(model.tables)
    bounds = sample_partitions(session, parameters, config, rng=rng)
    logs = partition_logs(tables, bounds)
    top = int(logs.argmax())
    weights = np.exp(logs - logs[top])
    weights /= weights.sum()
    effective = float(1.0 / np.square(weights).sum())
    marks = no_marks(tables)
    mark_partitions(tables, bounds, weights, marks)
    beliefs = read_looks(
        session,
        model,
        Occupancy(
            log_evidence=float(logs[top] + np.log(np.mean(np.exp(logs - logs[top])))),
            marks=marks,
            best_first=bounds[top, 0],
            best_past=bounds[top, 1],
        ),
    )
    return Sampled(beliefs=beliefs, effective_samples=effective)


def without_durations(tables: Tables) -> Tables:
    """Return the tables with every length that was possible alike."""
    return tables._replace(duration=np.where(tables.duration > NEVER / 2, 0.0, NEVER))


def sample_partitions(
    session: Session, parameters: Parameters, config: GlideConfig, *, rng: np.random.Generator
) -> IntArray:
    """Return (K, 2, A): first look and end of every action in every sample."""
    sights = session.sights
    look_s = session.span_s / sights.count
    gap = parameters.gap_fixations * look_s
    expected = [gap[0]]
    for a, act in enumerate(session.acts):
        follower = session.acts[a + 1] if a + 1 < len(session.acts) else None
        after = 3 if follower is None else (2 if follower.in_hand else 1)
        expected += [parameters.action_s[act.kind], gap[after]]
    alpha = config.dirichlet_strength * np.maximum(np.array(expected), 0.05)
    shares = rng.dirichlet(alpha, size=config.samples)
    edges = np.cumsum(shares, axis=1)[:, :-1] * session.span_s  # (K, 2 A)
    looks = np.searchsorted(sights.mid_s, edges)
    return np.stack([looks[:, 0::2], looks[:, 1::2]], axis=1)


@njit(cache=True)
def _thing_logs(tb: Tables, bounds: IntArray, first: int, past: int) -> FloatArray:
    """Return (H,): log of the looks in actions first to past - 1, all on the thing of h."""
    logs = np.full(tb.log_theta.shape[1], NEVER)
    terms = np.empty(tb.duration.shape[2])
    for h in hypotheses(tb, first):
        logs[h] = tb.log_theta[first, h]
        for a in range(first, past):
            s, e = bounds[0, a], bounds[1, a]
            if s == e:
                logs[h] += tb.skip[a, s]
            else:
                longest = segments(tb, a, h, s, terms)
                logs[h] += terms[e - s] if e - s <= longest else NEVER
    return logs


@njit(cache=True)
def _episode_end(tb: Tables, first: int) -> int:
    """Return one past the last action that goes on with the thing of action `first`."""
    past = first + 1
    while past < len(tb.in_hand) and tb.in_hand[past]:
        past += 1
    return past


@njit(cache=True)
def partition_logs(tb: Tables, bounds: IntArray) -> FloatArray:
    """Return (K,): log likelihood of the looks under each partition, eq. 24."""
    logs = np.zeros(len(bounds))
    for k in range(len(bounds)):
        first = 0
        while first < len(tb.in_hand):
            past = _episode_end(tb, first)
            logs[k] += log_sum(_thing_logs(tb, bounds[k], first, past))
            first = past
    return logs


@njit(cache=True)
def mark_partitions(tb: Tables, bounds: IntArray, weights: FloatArray, marks: Marks) -> None:
    """Fill the marks with the weighted samples, hypotheses by their posterior in each."""
    for k in np.flatnonzero(weights > 1e-12):
        first = 0
        while first < len(tb.in_hand):
            past = _episode_end(tb, first)
            logs = _thing_logs(tb, bounds[k], first, past)
            total = log_sum(logs)
            for h in np.flatnonzero(logs > total - 30.0):
                share = weights[k] * np.exp(logs[h] - total)
                for a in range(first, past):
                    mark(tb, marks, (a, h, bounds[k, 0, a], bounds[k, 1, a]), share)
            first = past
    cumulate(marks)
