"""What each look says: the mixture over target, location and landmark, against the background."""

import numpy as np

from grounding.glide.actions import Kind
from grounding.glide.config import GlideConfig
from grounding.glide.model import Parameters, Session
from grounding.glide.sight import log_density
from grounding.types import FloatArray

_RATIO_CAP = 8.5  # log; one look never says more for a position
_EYES_AHEAD_S = 3.0  # people look at a thing so long before it leaves


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


def moving(session: Session, ratio: FloatArray) -> FloatArray:
    """Return (T,): density of a look at what vision sees moved about now, over that of anywhere.

    Before a thing is taken people look at it, then at the place where it will be put.
    """
    rests, mid_s = session.rests, session.sights.mid_s[:, None]
    gone = np.flatnonzero(rests.next_rest >= 0)
    if not len(gone):
        return np.ones(session.sights.count)
    goal = rests.next_rest[gone]
    left_s, arrival_s = rests.left_s[gone], rests.since_s[goal]
    taking = (mid_s > left_s - _EYES_AHEAD_S) & (mid_s <= left_s)  # (T, M)
    putting = (mid_s > left_s) & (mid_s <= arrival_s)
    there = (taking * ratio[:, gone] + putting * ratio[:, goal]).sum(axis=1)
    now = (taking | putting).sum(axis=1)
    return np.where(now > 0, there / np.maximum(now, 1), 1.0)


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
