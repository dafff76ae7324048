"""From a session and its parameters to the factors of the semi-Markov model."""

from dataclasses import dataclass

import numpy as np

from grounding.glide.actions import Kind
from grounding.glide.config import GlideConfig
from grounding.glide.grid import Grid, grid_segments
from grounding.glide.kernels import NEVER, Tables
from grounding.glide.model import Parameters, Session, present
from grounding.glide.sight import log_density
from grounding.relations import PRIORS, wearer_axes
from grounding.types import FloatArray, IntArray

_LONGEST = 60  # looks in one action
_RATIO_CAP = 8.5  # log; one look never says more for a position
_NOT_THERE = -20.0
_SLACK_S = 0.5
_OPEN_END_SKIP = -0.7


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Model:
    """The factors, and what they were made of, to read the posterior with.

    Attributes:
        tables: the factors.
        ratio: (T, R) density of each look for each resting place over that of the background.
        landmark: (A, H, T) the same for the mixture over each action's landmarks.
        landmark_share: (A, H, R) the mixture's weights before time decides which place is taken.
        present: (T, R) whether the place was taken at the look's time.
        weights: (A, 3, 3) for each third of an action: of the target, the location, the landmark.
        grid: the grid of positions.
        grid_base: (G, T) density of the looks of a grid row without its position.
        grid_weight: (G,) weight of the position's component in that row.
    """

    tables: Tables
    ratio: FloatArray
    landmark: FloatArray
    landmark_share: FloatArray
    present: FloatArray
    weights: FloatArray
    grid: Grid
    grid_base: FloatArray
    grid_weight: FloatArray


def build(
    session: Session, parameters: Parameters, config: GlideConfig, *, open_end: bool = False
) -> Model:
    """Compute every factor of the model, eq. 1 to 5.

    Args:
        session: what was observed.
        parameters: what was learnt so far.
        config: the constants.
        open_end: the session goes on: actions may not have happened yet.

    Returns:
        The model; hypotheses are the resting places and, last, "elsewhere".
    """
    ratio = _place_ratio(session, parameters, config)
    taken = present(session, _mid_s(session), slack_s=_SLACK_S).astype(np.float64)
    share = _landmark_share(session, parameters)
    landmark = np.einsum("ahr,tr->aht", share, ratio * taken)
    weights = _weights(session, config)
    looks = _look_tables(session, ratio, landmark, weights)
    grid = Grid.over(session, parameters, config)
    row, base, weight = _grid_rows(session, landmark, weights)
    duration, cuts = _durations(session, parameters, config, open_end=open_end)
    stay, leave = _gaps(session, parameters)
    tables = Tables(
        kind=np.array([act.kind for act in session.acts], dtype=np.int64),
        in_hand=np.array([act.in_hand for act in session.acts], dtype=np.int64),
        log_theta=_log_theta(session, parameters, config),
        start=_starts(session, parameters, config),
        end=_ends(session, parameters, config, open_end=open_end),
        duration=duration,
        cuts=cuts,
        looks=looks,
        grid_row=row,
        grid=grid_segments(grid, base, weight, longest=duration.shape[2] - 1),
        stay=stay,
        leave=leave,
        skip=_skips(session, config, open_end=open_end),
    )
    return Model(
        tables=tables,
        ratio=ratio,
        landmark=landmark,
        landmark_share=share,
        present=taken,
        weights=weights,
        grid=grid,
        grid_base=base,
        grid_weight=weight,
    )


def _mid_s(session: Session) -> FloatArray:
    return 0.5 * (session.sights.start_s + session.sights.end_s)


def aim_cov(session: Session, config: GlideConfig) -> FloatArray:
    """Return (R, 3, 3): where on a thing people look, with the place's own covariance."""
    aim = np.maximum(config.aim_sigma_m * config.scene_unit_m, 0.15 * session.rests.extent)
    spread: FloatArray = session.rests.cov + (aim**2)[:, None, None] * np.eye(3)
    return spread


def _place_ratio(session: Session, parameters: Parameters, config: GlideConfig) -> FloatArray:
    log = log_density(
        session.sights,
        session.rests.position,
        aim_cov(session, config),
        offset_rad=parameters.gaze_offset_rad,
        scale=parameters.noise_scale,
    )
    return np.exp(np.minimum(log - log_background(session)[:, None], _RATIO_CAP))


def log_background(session: Session) -> FloatArray:
    """Return (T,) the log density of a look anywhere on the workspace, across its ray."""
    sights = session.sights
    steep = np.abs(sights.point[:, 2] - sights.origin[:, 2]) / np.maximum(sights.range_m, 1e-9)
    level = np.where(sights.has_ray & sights.seen, np.clip(steep, 0.1, 1.0), 1.0)
    return -np.log(session.area * level)


def _weights(session: Session, config: GlideConfig) -> FloatArray:
    """Return (A, 3, 3), eq. 3: thirds of an action by target, location, landmark."""
    weights = np.zeros((len(session.acts), 3, 3))
    inside = 1.0 - config.outlier_weight
    for a, act in enumerate(session.acts):
        if act.kind is not Kind.PUT:
            weights[a, :, 0] = inside
            continue
        early = np.array([1.0, 0.3, 0.3]) * config.in_hand_weight
        landmark = config.landmark_weight if act.landmarks else 0.0
        weights[a, :, 0] = inside * early
        weights[a, :, 2] = inside * landmark
        weights[a, :, 1] = inside * (1 - early - landmark)
    return weights


def _landmark_share(session: Session, parameters: Parameters) -> FloatArray:
    """Return (A, H, R): which place is the landmark if the thing is that of h, eq. 4."""
    rests, axes = session.rests, wearer_axes(session.heading_rad)
    share = np.zeros((len(session.acts), rests.count + 1, rests.count))
    if not rests.count:
        return share
    for a, act in enumerate(session.acts):
        if act.kind is not Kind.PUT or not act.landmarks:
            continue
        rows = list(session.names.landmarks_of_act[a])
        named = parameters.theta[rows].mean(axis=0)[rests.thing]  # (R,)
        prior = PRIORS.get(act.relation or "near", PRIORS["near"])
        for h in range(rests.count + 1):
            share[a, h] = named
            goal = rests.next_rest[h] if h < rests.count else -1
            if goal >= 0:
                offset = (rests.position[goal] - rests.position) @ axes.T - prior.mean_m
                far = np.square(offset[:, :2] / (2 * prior.sigma_m[:2])).sum(axis=1)
                share[a, h] = named * (np.exp(-0.5 * far) + 0.02) * (rests.thing != rests.thing[h])
        share[a] /= np.maximum(_sum_of_present(session, share[a]), 1e-12)
    return share


def _sum_of_present(session: Session, share: FloatArray) -> FloatArray:
    """Return (H, 1): each instance counted once, whichever of its places is taken."""
    once = np.zeros((share.shape[0], session.things_count))
    for r, k in enumerate(session.rests.thing):
        once[:, k] = np.maximum(once[:, k], share[:, r])
    total: FloatArray = once.sum(axis=1, keepdims=True)
    return total


def _look_tables(
    session: Session, ratio: FloatArray, landmark: FloatArray, weights: FloatArray
) -> FloatArray:
    """Return (A, H, 3, T + 1): cumulated log of the mixture in eq. 2."""
    count, places = ratio.shape
    looks = np.zeros((len(session.acts), places + 1, 3, count + 1))
    goal = session.rests.next_rest
    out = 1.0 - weights.sum(axis=2)  # (A, 3)
    at_goal = np.where(goal >= 0, ratio[:, goal], 0.0) if places else ratio  # (T, R)
    for a in range(len(session.acts)):
        w = weights[a][:, :, None, None]  # (3 thirds, 3 parts, 1, 1)
        mix = w[:, 0] * ratio.T + w[:, 1] * at_goal.T + w[:, 2] * landmark[a, :places]
        looks[a, :places, :, 1:] = np.cumsum(np.log(mix + out[a][:, None, None]), axis=2).transpose(
            1, 0, 2
        )
    return looks


def _grid_rows(
    session: Session, landmark: FloatArray, weights: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Say which segments have an unseen position, and what else their looks may be, eq. 5."""
    acts, things = len(session.acts), session.rests.count + 1
    row = np.full((acts, things), -1, dtype=np.int64)
    bases: list[FloatArray] = []
    position_weight: list[float] = []
    for a, act in enumerate(session.acts):
        put = act.kind is Kind.PUT
        unseen = [
            h for h in range(things) if h == things - 1 or (put and session.rests.next_rest[h] < 0)
        ]
        parts = weights[a].mean(axis=0)
        base = np.full(session.sights.count, 1.0 - weights[a].sum(axis=1).mean())
        if put:
            base = base + parts[2] * landmark[a, -1]
        weight = float(parts[1] + parts[0] if put else parts[0])
        same = [
            g
            for g, b in enumerate(bases)
            if position_weight[g] == weight and np.array_equal(b, base)
        ]
        row[a, unseen] = same[0] if same else len(bases)
        if not same:
            bases.append(base)
            position_weight.append(weight)
    return row, np.array(bases).reshape(-1, session.sights.count), np.array(position_weight)


def _log_theta(session: Session, parameters: Parameters, config: GlideConfig) -> FloatArray:
    """Return (A, H): the prior of what a phrase means, eq. 12."""
    rests = session.rests
    log_theta = np.full((len(session.acts), rests.count + 1), NEVER)
    unseen = config.unseen_prior if rests.count else 1.0
    for a in range(len(session.acts)):
        if rests.count:
            named = parameters.theta[session.names.of_act[a]][rests.thing]
            log_theta[a, :-1] = np.log(np.maximum((1 - unseen) * named, 1e-9))
        log_theta[a, -1] = np.log(unseen)
    return log_theta


def _near(
    times_s: FloatArray,
    event_s: FloatArray | float,
    *,
    sigma_s: float,
    missed: float,
    span_s: float,
) -> FloatArray:
    """Return the log of a normal about an event with a flat floor, over the flat density, eq. 8."""
    z = (times_s - event_s) / sigma_s
    density = np.exp(-0.5 * z * z) / (sigma_s * np.sqrt(2 * np.pi))
    return np.asarray(np.log((1 - missed) * density * span_s + missed))


def _starts(session: Session, parameters: Parameters, config: GlideConfig) -> FloatArray:
    """Return (A, H, T + 1): narration and presence at the start of an action, eq. 7."""
    rests, sights = session.rests, session.sights
    begin = np.append(sights.start_s, session.span_s)
    start = np.zeros((len(session.acts), rests.count + 1, sights.count + 1))
    here = (begin[None] >= rests.since_s[:, None] - _SLACK_S) & (
        begin[None] <= rests.left_s[:, None] + _SLACK_S
    )
    seen_instructions: set[int] = set()
    for a, act in enumerate(session.acts):
        if act.kind is not Kind.PUT:
            start[a, :-1] += np.where(here, 0.0, _NOT_THERE)
        said = session.said_s[act.instruction]
        if np.isfinite(said) and act.instruction not in seen_instructions:
            start[a] += _near(
                begin,
                said - parameters.narration_shift_s,
                sigma_s=parameters.narration_sigma_s,
                missed=config.narration_outlier,
                span_s=session.span_s,
            )
        seen_instructions.add(act.instruction)
    return start


def _ends(
    session: Session, parameters: Parameters, config: GlideConfig, *, open_end: bool
) -> FloatArray:
    """Return (A, H, T + 1): what vision saw of the movement, at the end of an action, eq. 8."""
    rests, sights = session.rests, session.sights
    finish = np.concatenate([[0.0], sights.end_s])
    end = np.zeros((len(session.acts), rests.count + 1, sights.count + 1))
    if not session.motion_seen:
        return end
    for a, act in enumerate(session.acts):
        for h in range(rests.count if act.kind is not Kind.AT else 0):
            event = rests.left_s[h] if act.kind is Kind.TAKE else _arrival(session, h)
            if np.isfinite(event):
                end[a, h] = _near(
                    finish,
                    event + parameters.motion_shift_s[act.kind],
                    sigma_s=config.motion_sigma_s,
                    missed=config.motion_missed,
                    span_s=session.span_s,
                )
            elif act.kind is Kind.TAKE:
                end[a, h] = np.log(config.unmoved_prior)
    if open_end:
        end[..., -1] = np.maximum(end[..., -1], 0.0)
    return end


def _arrival(session: Session, h: int) -> float:
    goal = session.rests.next_rest[h]
    return float(session.rests.since_s[goal]) if goal >= 0 else np.inf


def _durations(
    session: Session, parameters: Parameters, config: GlideConfig, *, open_end: bool
) -> tuple[FloatArray, IntArray]:
    """Return log-normal durations (3, T, D + 1), eq. 6, and the thirds' edges (T, D + 1, 2)."""
    sights, count = session.sights, session.sights.count
    limit = min(
        config.action_max_s,
        float(parameters.action_s.max()) * np.exp(2.5 * config.action_log_sigma),
    )
    first, past = (
        np.arange(count)[:, None],
        np.arange(count)[:, None] + np.arange(_LONGEST + 1)[None],
    )
    last = np.clip(past - 1, 0, max(count - 1, 0))
    lasts = np.maximum(sights.end_s[last] - sights.start_s[:, None], 0.05)
    allowed = (past <= count) & (lasts <= limit) & (past > first)
    longest = max(1, int(np.max(np.where(allowed, past - first, 1), initial=1)))
    allowed, lasts = allowed[:, : longest + 1], lasts[:, : longest + 1]
    duration = np.empty((3, count, longest + 1))
    for kind in range(3):
        z = (np.log(lasts) - np.log(parameters.action_s[kind])) / config.action_log_sigma
        shape = -0.5 * z * z
        if open_end:
            ends_now = past[:, : longest + 1] == count
            shape = np.where(ends_now, np.where(z < 0, 0.0, shape), shape)
        duration[kind] = np.where(allowed, shape, NEVER)
    cuts = np.empty((count, longest + 1, 2), dtype=np.int64)
    mid = _mid_s(session)
    for k in range(2):
        at = sights.start_s[:, None] + (k + 1) / 3 * lasts
        cuts[..., k] = np.clip(
            np.searchsorted(mid, at), first, np.minimum(past[:, : longest + 1], count)
        )
    return duration, cuts


def _gaps(session: Session, parameters: Parameters) -> tuple[FloatArray, FloatArray]:
    """Return the geometric background lengths (A + 1,) as logs of staying and leaving, eq. 9."""
    acts = session.acts
    mean = np.full(len(acts) + 1, parameters.gap_fixations[1])
    for a, act in enumerate(acts):
        if act.in_hand:
            mean[a] = parameters.gap_fixations[2]
    mean[0], mean[-1] = parameters.gap_fixations[0], parameters.gap_fixations[3]
    return np.log(mean / (1 + mean)), -np.log1p(mean)


def _skips(session: Session, config: GlideConfig, *, open_end: bool) -> FloatArray:
    skip = np.full((len(session.acts), session.sights.count + 1), np.log(config.skip_prior))
    if open_end:
        skip[:, -1] = _OPEN_END_SKIP
    return skip
