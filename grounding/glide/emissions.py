"""What each look says: the mixture over target, location and landmark, against the background."""

import numpy as np

from grounding.glide.actions import Kind
from grounding.glide.config import GlideConfig
from grounding.glide.model import Parameters, Session
from grounding.glide.sight import log_density
from grounding.relations import sense_of, wearer_axes
from grounding.types import FloatArray

_RATIO_CAP = 8.5  # log; one look never says more for a position


def aim_cov(session: Session, config: GlideConfig) -> FloatArray:
    """Return (R, 3, 3): where on a thing people look, with the place's own covariance."""
    aim = np.maximum(config.aim_sigma_m * config.scene_unit_m, 0.15 * session.rests.extent)
    spread: FloatArray = session.rests.cov + (aim**2)[:, None, None] * np.eye(3)
    return spread


def place_ratio(session: Session, parameters: Parameters, config: GlideConfig) -> FloatArray:
    """Return (T, R): density of each look for each place over that of a look anywhere, eq. 2."""
    log = log_density(
        session.sights,
        session.rests.position,
        aim_cov(session, config),
        offset_rad=parameters.gaze_offset_rad,
        scale=parameters.noise_scale,
    )
    return np.exp(np.minimum(log - _log_anywhere(session)[:, None], _RATIO_CAP))


def _log_anywhere(session: Session) -> FloatArray:
    """Return (T,) the log density of a look anywhere on the workspace, across its ray."""
    sights = session.sights
    steep = np.abs(sights.point[:, 2] - sights.origin[:, 2]) / np.maximum(sights.range_m, 1e-9)
    level = np.where(sights.has_ray & sights.seen, np.clip(steep, 0.1, 1.0), 1.0)
    return -np.log(session.area * level)


def popularity(session: Session, ratio: FloatArray, taken: FloatArray) -> FloatArray:
    """Return (T,): density of a look at any one of the things there are, over that of anywhere."""
    if not session.rests.count:
        return np.ones(session.sights.count)
    mean: FloatArray = (ratio * taken).sum(axis=1) / session.things_count
    return mean


def part_weights(session: Session, config: GlideConfig) -> FloatArray:
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


def landmark_shares(session: Session, parameters: Parameters) -> FloatArray:
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
        sense = sense_of(act.relation or "near")
        direction, sigma = np.array(sense.direction[:2]), 2 * np.array(sense.sigma_m[:2])
        for h in range(rests.count + 1):
            share[a, h] = named
            goal = rests.next_rest[h] if h < rests.count else -1
            if goal >= 0:
                apart = 0.5 * (rests.extent + rests.extent[h]) + sense.clearance_m
                offset = (rests.position[goal] - rests.position) @ axes.T
                off = offset[:, :2] - apart[:, None] * direction
                far = np.square(off / sigma).sum(axis=1)
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


def look_tables(
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
