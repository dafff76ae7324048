"""What a thing was put beside: which landmark is meant, and whether the place fits the words."""

import numpy as np

from grounding.glide.actions import Act, Kind
from grounding.glide.config import GlideConfig
from grounding.glide.model import Parameters, Session
from grounding.relations import SENSES, sense_of, wearer_axes
from grounding.types import FloatArray

_ANYWAY = 0.02  # of a landmark that the thing was not put beside
_LEAST_SPREAD_M = 0.03


def tells_place(act: Act) -> bool:
    """Return whether the words say where, about one landmark, a thing is put."""
    told = act.kind is Kind.PUT and len(act.landmarks) == 1
    return told and act.relation in SENSES and act.relation != "between"


def landmark_shares(session: Session, parameters: Parameters, config: GlideConfig) -> FloatArray:
    """Return (A, H, R): which place is the landmark if the thing is that of h, eq. 4."""
    rests = session.rests
    share = np.zeros((len(session.acts), rests.count + 1, rests.count))
    if not rests.count:
        return share
    for a, act in enumerate(session.acts):
        if act.kind is not Kind.PUT or not act.landmarks:
            continue
        named = parameters.landmark_theta[a][rests.thing]  # (R,)
        share[a] = named
        seen = np.flatnonzero(rests.next_rest >= 0)
        share[a, seen] = named * _others(session)[seen]
        if tells_place(act):
            share[a, seen] *= _likeness(session, act, config)[seen] + _ANYWAY
        share[a] /= np.maximum(_sum_of_present(session, share[a]), 1e-12)
    return share


def landings(session: Session, parameters: Parameters, config: GlideConfig) -> FloatArray:
    """Return (A, R): log of how much better than anywhere the next place of h fits the words.

    The place that a thing was put to is as the relation says about one of the things that its
    landmark may be, or anywhere, eq. 8b.
    """
    rests = session.rests
    fits = np.zeros((len(session.acts), rests.count))
    seen = np.flatnonzero(rests.next_rest >= 0)
    if not len(seen):
        return fits
    arrival = rests.since_s[rests.next_rest[seen]]
    standing = (rests.since_s <= arrival[:, None]) & (arrival[:, None] < rests.left_s)  # (S, R)
    stood = standing * _others(session)[seen]
    for a, act in enumerate(session.acts):
        if not tells_place(act):
            continue
        named = parameters.landmark_theta[a][rests.thing]
        sigma = _spread(act, config)
        density = _likeness(session, act, config)[seen] / (2 * np.pi * sigma[0] * sigma[1])
        there = session.area * (density * named * stood).sum(axis=1)
        missed = config.relation_missed
        fits[a, seen] = np.log(missed + (1 - missed) * there)
    return fits


def _spread(act: Act, config: GlideConfig) -> FloatArray:
    """Return (2,) to the right and forward: twice what people are expected to keep to."""
    sigma = 2 * np.array(sense_of(act.relation or "near").sigma_m[:2])
    spread: FloatArray = np.maximum(sigma, _LEAST_SPREAD_M) * config.scene_unit_m
    return spread


def _likeness(session: Session, act: Act, config: GlideConfig) -> FloatArray:
    """Return (R, R), 1 at best: how well the next place of each row is in relation to each place.

    Rows of places without a next one mean nothing.
    """
    rests = session.rests
    goal = rests.position[rests.next_rest]
    return beside(session, config, act, extent=rests.extent[:, None], points=goal)


def beside(
    session: Session,
    config: GlideConfig,
    act: Act,
    *,
    extent: FloatArray | float,
    points: FloatArray,
) -> FloatArray:
    """Return (P, R), 1 at best: how well a thing at each point is in relation to each place.

    Args:
        session: whose places are the landmarks.
        config: the constants.
        act: whose relation is asked for.
        extent: level size of the thing, one or (P, 1).
        points: (P, 3) where its middle may be.
    """
    rests, unit = session.rests, config.scene_unit_m
    sense = sense_of(act.relation or "near")
    apart = 0.5 * (rests.extent + extent) + sense.clearance_m * unit  # (P or 1, R)
    offset = (points[:, None] - rests.position) @ wearer_axes(session.heading_rad).T
    off = offset[..., :2] - np.asarray(apart)[..., None] * np.array(sense.direction[:2])
    return np.asarray(np.exp(-0.5 * np.square(off / _spread(act, config)).sum(axis=2)))


def _others(session: Session) -> FloatArray:
    """Return (R, R): 1 where two places are of two things; nothing is put beside itself."""
    thing = session.rests.thing
    differs: FloatArray = (thing != thing[:, None]).astype(np.float64)
    return differs


def _sum_of_present(session: Session, share: FloatArray) -> FloatArray:
    """Return (H, 1): each instance counted once, whichever of its places is taken."""
    once = np.zeros((share.shape[0], session.things_count))
    for r, k in enumerate(session.rests.thing):
        once[:, k] = np.maximum(once[:, k], share[:, r])
    total: FloatArray = once.sum(axis=1, keepdims=True)
    return total
