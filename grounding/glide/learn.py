"""Learning the session's parameters: expectation-maximisation with priors, eq. 18 to 23."""

import dataclasses

import numpy as np

from grounding.glide.actions import Kind
from grounding.glide.config import GlideConfig
from grounding.glide.emissions import aim_cov
from grounding.glide.exact import Beliefs
from grounding.glide.model import Parameters, Session
from grounding.glide.sight import residuals
from grounding.glide.tables import Model
from grounding.types import FloatArray

# Pseudo-observations of the priors: how much is seen before a session is believed.
_MEANING_PRIOR = 0.3
_TIME_PRIOR = 3.0
_GAP_PRIOR = 2.0
_NOISE_PRIOR = 20.0
_POPULAR_PRIOR = 5.0
_NARRATION_FLOOR_S = 0.3
_NARRATION_PRIOR_S = 0.8
_SHIFT_PRIOR_S = 1.0
_MOTION_SHIFT_PRIOR_S = 0.3


def update(
    session: Session, parameters: Parameters, beliefs: Beliefs, model: Model, config: GlideConfig
) -> Parameters:
    """Return the parameters that explain the session best given the beliefs, and the priors."""
    shift, sigma = _narration(session, parameters, beliefs, config)
    theta, landmark_theta = _meanings(session, beliefs, model)
    offset, scale = _gaze(session, parameters, beliefs, config)
    return dataclasses.replace(
        parameters,
        theta=theta,
        landmark_theta=landmark_theta,
        narration_shift_s=shift,
        narration_sigma_s=sigma,
        action_s=_action_s(session, parameters, beliefs),
        gap_fixations=_gaps(session, beliefs, config),
        gaze_offset_rad=offset,
        noise_scale=scale,
        motion_shift_s=_motion_shift(session, beliefs, config),
        popular_share=_popular_share(parameters, beliefs, model, config),
    )


def _meanings(session: Session, beliefs: Beliefs, model: Model) -> tuple[FloatArray, FloatArray]:
    """Say for each act what its phrases meant elsewhere in the session, eq. 18.

    An act is no evidence for itself: with its own posterior among the counts, learning would make
    it sure of whatever it leaned to, such as one of two things that fit the words equally well.
    (Collapsed variational Bayes: Asuncion, Welling, Smyth and Teh 2009, "CVB0".)

    Returns:
        (A, O) for the act's thing, and (A, O) for its landmarks, the mean over their phrases.
    """
    acts, things = len(session.acts), max(session.things_count, 1)
    counts = np.full((len(session.names.phrases), things), _MEANING_PRIOR / things)
    of_thing, of_landmark = np.zeros((acts, things)), np.zeros((acts, things))
    thing = session.rests.thing
    for a, act in enumerate(session.acts):
        done, rows = 1.0 - beliefs.skipped[a], session.names.landmarks_of_act[a]
        if not act.in_hand:
            np.add.at(of_thing[a], thing, done * beliefs.things[a, :-1])
            counts[session.names.of_act[a]] += of_thing[a]
        if rows:
            geometry = _geometry_only(model.landmark_share[a, :-1])
            share = beliefs.on_landmark[a] + done * (beliefs.things[a, :-1] @ geometry)
            np.add.at(of_landmark[a], thing, share / len(rows))
        for row in rows:
            counts[row] += of_landmark[a]
    rivals = _rivals(session) @ counts
    theta = np.array([_meaning(counts[i] - own, rivals[i]) for i, own in _owns(session, of_thing)])
    named = np.zeros((acts, things))
    for a, rows in enumerate(session.names.landmarks_of_act):
        for row in rows:
            named[a] += _meaning(counts[row] - of_landmark[a], rivals[row]) / len(rows)
    return theta, named


def _owns(session: Session, of_thing: FloatArray) -> list[tuple[int, FloatArray]]:
    """Return for each act the row of its thing's phrase, and what the act itself said of it.

    What is in hand was named when it was taken.
    """
    names = session.names.of_act
    owns: list[tuple[int, FloatArray]] = []
    for a, act in enumerate(session.acts):
        is_same = act.in_hand and a > 0 and names[a] == names[a - 1]
        owns.append((names[a], owns[-1][1] if is_same else of_thing[a]))
    return owns


def _meaning(counts: FloatArray, rivals: FloatArray) -> FloatArray:
    """Return (O,) what a phrase means by its counts.

    A thing that another phrase already means is less likely meant by this one: people who learn
    words assume so too (mutual exclusivity, Markman and Wachtel 1988).
    """
    owned = counts * counts / (counts + rivals)
    return np.asarray(owned / owned.sum())


def _rivals(session: Session) -> FloatArray:
    """Return (N, N): 1 where two phrases do not mean one thing: neither only says more words."""
    words = [frozenset(phrase) for phrase in session.names.phrases]
    return np.array([[float(not (a <= b or b <= a)) for b in words] for a in words])


def _geometry_only(share: FloatArray) -> FloatArray:
    """Normalise the landmark's weights over the places."""
    return np.asarray(share / np.maximum(share.sum(axis=1, keepdims=True), 1e-12))


def _expected_s(probability: FloatArray, times_s: FloatArray) -> FloatArray:
    mass = probability.sum(axis=1)
    return np.asarray(np.where(mass > 1e-6, probability @ times_s / np.maximum(mass, 1e-6), np.nan))


def _start_s(session: Session, beliefs: Beliefs) -> FloatArray:
    return _expected_s(beliefs.begins, np.append(session.sights.start_s, session.span_s))


def _end_s(session: Session, beliefs: Beliefs) -> FloatArray:
    return _expected_s(beliefs.ends, np.concatenate([[0.0], session.sights.end_s]))


def _narration(
    session: Session, parameters: Parameters, beliefs: Beliefs, config: GlideConfig
) -> tuple[float, float]:
    """Return shift and spread of speech against action, outliers left out softly, eq. 19."""
    begin, weight, said = _start_s(session, beliefs), [], []
    seen: set[int] = set()
    for a, act in enumerate(session.acts):
        late = session.said_s[act.instruction] - begin[a]
        if act.instruction not in seen and np.isfinite(late):
            sigma = parameters.narration_sigma_s
            z = (late - parameters.narration_shift_s) / sigma
            good = (
                (1 - config.narration_outlier) * np.exp(-0.5 * z * z) / (sigma * np.sqrt(2 * np.pi))
            )
            weight.append(
                (1 - beliefs.skipped[a]) * good / (good + config.narration_outlier / session.span_s)
            )
            said.append(late)
        seen.add(act.instruction)
    w, r = np.array(weight), np.array(said)
    if w.sum() < 1.5:
        return 0.0, config.narration_sigma_s
    prior = (parameters.narration_sigma_s / _SHIFT_PRIOR_S) ** 2
    shift = float(w @ r / (w.sum() + prior))
    variance = (w @ np.square(r - shift) + 2 * _NARRATION_PRIOR_S**2) / (w.sum() + 2)
    return shift, max(float(np.sqrt(variance)), _NARRATION_FLOOR_S)


def _action_s(session: Session, parameters: Parameters, beliefs: Beliefs) -> FloatArray:
    """Return the median durations, eq. 20."""
    lasts = np.log(np.maximum(_end_s(session, beliefs) - _start_s(session, beliefs), 0.1))
    kinds = np.array([act.kind for act in session.acts])
    weight = np.where(np.isfinite(lasts), 1 - beliefs.skipped, 0.0)
    lasts = np.where(np.isfinite(lasts), lasts, 0.0)
    overall = float((weight @ lasts + 1e-9) / (weight.sum() + 1e-9))
    result = parameters.action_s.copy()
    for kind in Kind:
        w = weight[kinds == kind]
        mean = (w @ lasts[kinds == kind] + _TIME_PRIOR * overall) / (w.sum() + _TIME_PRIOR)
        result[kind] = np.clip(np.exp(mean), 0.5, 8.0)
    return result


def _gaps(session: Session, beliefs: Beliefs, config: GlideConfig) -> FloatArray:
    """Return the expected background looks of each sort of gap, eq. 20."""
    count = session.sights.count
    steps = np.arange(count + 1, dtype=np.float64)
    begin, end = _expected_s(beliefs.begins, steps), _expected_s(beliefs.ends, steps)
    gaps: list[list[float]] = [[], [], [], []]
    gaps[0].append(float(begin[0]))
    gaps[3].append(float(count - end[-1]))
    for a in range(1, len(session.acts)):
        gaps[2 if session.acts[a].in_hand else 1].append(float(begin[a] - end[a - 1]))
    prior = session.gap_looks(config)
    found = [np.array(g)[np.isfinite(g)] for g in gaps]
    total = np.array([np.maximum(g, 0).sum() for g in found])
    number = np.array([len(g) for g in found])
    return np.asarray((total + _GAP_PRIOR * prior) / (number + _GAP_PRIOR))


def _gaze(
    session: Session, parameters: Parameters, beliefs: Beliefs, config: GlideConfig
) -> tuple[FloatArray, float]:
    """Return the gaze offset that is left, and the factor on the measurement's spread, eq. 21."""
    sights, rests = session.sights, session.rests
    if not rests.count:
        return np.zeros(2), 1.0
    weight = beliefs.on_place * sights.seen[:, None]  # (T, R)
    off = residuals(sights, rests.position, offset_rad=np.zeros(2))  # (T, R, 2)
    spread = np.einsum("tac,pcd,tbd->tpab", sights.across, aim_cov(session, config), sights.across)
    spread = spread + parameters.noise_scale**2 * sights.cov[:, None]
    precision = np.linalg.inv(spread) * weight[..., None, None]
    lever = np.where(sights.has_ray, sights.range_m, 0.0)
    information = np.einsum("t,tpab->ab", lever**2, precision)
    information += np.eye(2) / config.gaze_offset_sigma_rad**2
    offset = np.linalg.solve(information, np.einsum("t,tpab,tpb->a", lever, precision, off))
    rest = off - lever[:, None, None] * offset
    squared = float(np.einsum("tpa,tpab,tpb->", rest, precision, rest))
    looks = 2 * float(weight.sum())
    factor = (squared + _NOISE_PRIOR) / (looks + _NOISE_PRIOR)
    return offset, float(np.clip(parameters.noise_scale * np.sqrt(factor), 0.3, 4.0))


def _popular_share(
    parameters: Parameters, beliefs: Beliefs, model: Model, config: GlideConfig
) -> float:
    """Return the share of idle looks that rest on things, eq. 22."""
    idle = 1.0 - np.minimum(beliefs.member.sum(axis=0), 1.0)
    share = parameters.popular_share
    on_things = share * model.popular / (share * model.popular + 1.0 - share)
    total = float(idle @ on_things) + _POPULAR_PRIOR * config.popular_share
    return float(np.clip(total / (float(idle.sum()) + _POPULAR_PRIOR), 0.01, 0.95))


def _motion_shift(session: Session, beliefs: Beliefs, config: GlideConfig) -> FloatArray:
    """Return how long after the event that vision saw an action ends, eq. 23."""
    end, rests = _end_s(session, beliefs), session.rests
    total, number = np.zeros(3), np.zeros(3)
    for a, act in enumerate(session.acts):
        h = int(beliefs.things[a].argmax())
        if h >= rests.count or act.kind is Kind.AT or not np.isfinite(end[a]):
            continue
        goal = rests.next_rest[h]
        event = (
            rests.left_s[h]
            if act.kind is Kind.TAKE
            else (rests.since_s[goal] if goal >= 0 else np.inf)
        )
        late = end[a] - event
        if np.isfinite(late) and abs(late) < 3 * config.motion_sigma_s + _MOTION_SHIFT_PRIOR_S:
            total[act.kind] += late
            number[act.kind] += 1
    prior = (config.motion_sigma_s / _MOTION_SHIFT_PRIOR_S) ** 2
    return np.asarray(total / (number + prior))
