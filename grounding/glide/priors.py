"""Factors of when and what, before any look is weighed: meanings, times, durations, gaps."""

import numpy as np

from grounding.glide.actions import Kind
from grounding.glide.config import GlideConfig
from grounding.glide.kernels import NEVER
from grounding.glide.model import Parameters, Session
from grounding.types import FloatArray, IntArray

_LONGEST = 60  # looks in one action
_PRESENT_SLACK_S = 2.0
_OPEN_END_SKIP = -0.7


def log_theta(session: Session, parameters: Parameters, config: GlideConfig) -> FloatArray:
    """Return (A, H): the prior of what a phrase means, eq. 10."""
    rests = session.rests
    logs = np.full((len(session.acts), rests.count + 1), NEVER)
    unseen = config.unseen_prior if rests.count else 1.0
    for a in range(len(session.acts)):
        if rests.count:
            named = parameters.theta[a][rests.thing]
            logs[a, :-1] = np.log(np.maximum((1 - unseen) * named, 1e-9))
            logs[a, :-1][~session.allowed[a, rests.thing]] = NEVER
        logs[a, -1] = np.log(unseen) if session.allowed[a].all() else NEVER
    return logs


def starts(session: Session, parameters: Parameters, config: GlideConfig) -> FloatArray:
    """Return (A, H, T + 1): narration, and presence of the thing, at the start, eq. 7."""
    rests, sights = session.rests, session.sights
    begin = np.append(sights.start_s, session.span_s)
    factor = np.zeros((len(session.acts), rests.count + 1, sights.count + 1))
    early = begin[None] < rests.since_s[:, None] - _PRESENT_SLACK_S
    late = begin[None] > rests.left_s[:, None] + _PRESENT_SLACK_S
    begun: set[int] = set()
    for a, act in enumerate(session.acts):
        said = session.said_s[act.instruction]
        if np.isfinite(said) and act.instruction not in begun:
            shape = (said - parameters.narration_shift_s, parameters.narration_sigma_s)
            factor[a] += _near(begin, shape, missed=config.narration_outlier, session=session)
        if act.kind is not Kind.PUT:
            factor[a, :-1][early | late] = NEVER
        begun.add(act.instruction)
    return factor


def ends(
    session: Session, parameters: Parameters, config: GlideConfig, *, open_end: bool
) -> FloatArray:
    """Return (A, H, T + 1): what vision saw of the movement, at the end of an action, eq. 8."""
    rests, sights = session.rests, session.sights
    finish = np.concatenate([[0.0], sights.end_s])
    factor = np.zeros((len(session.acts), rests.count + 1, sights.count + 1))
    if not session.motion_seen:
        return factor
    for a, act in enumerate(session.acts):
        for h in range(rests.count if act.kind is not Kind.AT else 0):
            event = float(rests.left_s[h]) if act.kind is Kind.TAKE else arrival_s(session, h)
            if np.isfinite(event):
                event += float(parameters.motion_shift_s[act.kind])
                shape = (event, config.motion_sigma_s)
                factor[a, h] = _near(finish, shape, missed=config.motion_missed, session=session)
                factor[a, h][np.abs(finish - event) > config.motion_window_s] = NEVER
            elif act.kind is Kind.TAKE:
                factor[a, h] = np.log(config.unmoved_prior)
    if open_end:
        factor[..., -1] = np.maximum(factor[..., -1], 0.0)
    return factor


def without_dead_ends(start: FloatArray, end: FloatArray, *, longest: int) -> FloatArray:
    """Return the starts, those from which no end can be reached ruled out."""
    count = start.shape[2] - 1
    can_end = end > NEVER / 2
    first = np.where(can_end.any(axis=2), can_end.argmax(axis=2), count + 1)
    last = count - can_end[..., ::-1].argmax(axis=2)
    s = np.arange(count + 1)
    reaches = (first[..., None] <= s + longest) & (last[..., None] > s) & (s < count)
    return np.where(reaches, start, NEVER)


def arrival_s(session: Session, h: int) -> float:
    """Return when the thing at a resting place came to rest at the next one; inf if it did not."""
    goal = session.rests.next_rest[h]
    return float(session.rests.since_s[goal]) if goal >= 0 else np.inf


def durations(
    session: Session, parameters: Parameters, config: GlideConfig, *, open_end: bool
) -> tuple[FloatArray, IntArray]:
    """Return log-normal durations (3, T, D + 1), eq. 6, and the thirds' edges (T, D + 1, 2)."""
    sights, count = session.sights, session.sights.count
    slowest = float(parameters.action_s.max())
    limit = min(config.action_max_s, slowest * np.exp(2.5 * config.action_log_sigma))
    first = np.arange(count)[:, None]
    past = first + np.arange(_LONGEST + 1)[None]
    last = np.clip(past - 1, 0, max(count - 1, 0))
    lasts = np.maximum(sights.end_s[last] - sights.start_s[:, None], 0.05)
    allowed = (past <= count) & (lasts <= limit) & (past > first)
    longest = max(1, int(np.max(np.where(allowed, past - first, 1), initial=1)))
    allowed, lasts, past = (x[:, : longest + 1] for x in (allowed, lasts, past))
    factor = np.empty((3, count, longest + 1))
    for kind in Kind:
        z = (np.log(lasts) - np.log(parameters.action_s[kind])) / config.action_log_sigma
        shape = -0.5 * z * z
        if open_end:  # it may go on after the last look
            shape = np.where((past == count) & (z < 0), 0.0, shape)
        factor[kind] = np.where(allowed, shape, NEVER)
    edges = [sights.start_s[:, None] + (k + 1) / 3 * lasts for k in range(2)]
    cuts = np.stack([np.searchsorted(sights.mid_s, edge) for edge in edges], axis=-1)
    return factor, np.clip(cuts, first[..., None], np.minimum(past, count)[..., None])


def gaps(session: Session, parameters: Parameters) -> tuple[FloatArray, FloatArray]:
    """Return the geometric background lengths (A + 1,) as logs of staying and leaving, eq. 9."""
    acts = session.acts
    mean = np.full(len(acts) + 1, parameters.gap_fixations[1])
    for a, act in enumerate(acts):
        if act.in_hand:
            mean[a] = parameters.gap_fixations[2]
    mean[0], mean[-1] = parameters.gap_fixations[0], parameters.gap_fixations[3]
    return np.log(mean / (1 + mean)), -np.log1p(mean)


def skips(session: Session, config: GlideConfig, *, open_end: bool) -> FloatArray:
    """Return (A, T + 1): log of an action that was said and not done."""
    skip = np.full((len(session.acts), session.sights.count + 1), np.log(config.skip_prior))
    if open_end:
        skip[:, -1] = _OPEN_END_SKIP
    return skip


def _near(
    times_s: FloatArray, shape: tuple[float, float], *, missed: float, session: Session
) -> FloatArray:
    """Return the log of a normal (mean, sigma) on a flat floor, over the flat density, eq. 7."""
    z = (times_s - shape[0]) / shape[1]
    density = np.exp(-0.5 * z * z) / (shape[1] * np.sqrt(2 * np.pi))
    return np.asarray(np.log((1 - missed) * density * session.span_s + missed))
