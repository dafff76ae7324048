"""From the grounded plan to the times and places at which its targets can be pictured."""

from collections.abc import Sequence

import numpy as np

from grounding.glide.read import Candidate
from grounding.patches.cut import PatchConfig, Showing
from grounding.plan import GroundedInstruction, GroundedPlan
from grounding.types import FixationObservation, FloatArray, ObjectInstance, RestingPlace

_GATE_SIGMAS = 3.0
_LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


def showings_of(
    plan: GroundedPlan,
    objects: Sequence[ObjectInstance],
    fixations: Sequence[FixationObservation],
    config: PatchConfig,
) -> list[Showing]:
    """Return where each instruction's target stands still, before it is taken and after it was put.

    Args:
        plan: the grounded plan.
        objects: the instances of vision.
        fixations: the looks, for the gate of three sigma and the session's span.
        config: how patches are cut.

    Returns:
        At most one showing for each instruction: before the action, or, for an action that puts
        the target somewhere, after it.
    """
    if not fixations:
        return []
    found = []
    for each in plan.instructions:
        best = each.target or (each.candidates[0] if each.candidates else None)
        if best is None or each.start_ns is None or each.end_ns is None:
            continue
        showing = _showing(each, best, objects, fixations, config)
        if showing is not None:
            found.append(showing)
    return found


def _showing(
    each: GroundedInstruction,
    best: Candidate,
    objects: Sequence[ObjectInstance],
    fixations: Sequence[FixationObservation],
    config: PatchConfig,
) -> Showing | None:
    place = _resting_place(each, best, objects, fixations)
    if place is None:
        return None
    margin = (int(config.after_s * 1e9), int(config.before_s * 1e9))
    first_ns, last_ns = min(f.start_ns for f in fixations), max(f.end_ns for f in fixations)
    since = max(place.t_ns + margin[0], first_ns)
    until = last_ns if place.left_ns is None else place.left_ns - margin[1]
    size = best.size_m if best.size_m is not None else np.full(3, config.unseen_size_m)
    mine = [f for f in fixations if f.fixation_id in set(each.fixations)]
    spots = [best.spot.position_world, place.position_world]
    return Showing(
        instruction=each.spoken.index,
        symbols=each.spoken.instruction.target,
        weight=min(each.confidence, best.probability),
        object_id=best.object_id,
        position_world=place.position_world,
        quat_xyzw=place.quat_xyzw,
        size_m=size,
        since_ns=since,
        until_ns=until,
        is_looked_at=any(_within_gate(f, spot, size) for f in mine for spot in spots),
    )


def _resting_place(
    each: GroundedInstruction,
    best: Candidate,
    objects: Sequence[ObjectInstance],
    fixations: Sequence[FixationObservation],
) -> RestingPlace | None:
    """Return the place to picture: the new one for an action that moved the target."""
    moved = each.location is not None and (
        np.linalg.norm(each.location.position_world - best.spot.position_world) > 1e-6
    )
    goal = each.location if moved and each.location else best.spot
    for thing in objects:
        if thing.object_id == best.object_id:
            off = [np.linalg.norm(p.position_world - goal.position_world) for p in thing.track]
            nearest = thing.track[int(np.argmin(off))]
            if min(off) < 1e-3:
                return nearest
    # Vision did not see it stand there: trust the gaze, and the action's times.
    start = each.end_ns if moved else min(f.start_ns for f in fixations)
    if start is None:
        return None
    return RestingPlace(
        t_ns=start,
        left_ns=None if moved else each.start_ns,
        position_world=goal.position_world,
        quat_xyzw=_LEVEL if best.quat_xyzw is None else best.quat_xyzw,
        cov_world=goal.cov_world,
    )


def _within_gate(fixation: FixationObservation, spot: FloatArray, size_m: FloatArray) -> bool:
    """Return whether a look passes within three sigma of a thing."""
    if fixation.point_world is None or fixation.cov_world is None:
        return False
    cov = fixation.cov_world + np.diag(np.square(size_m / 2))
    off = spot - fixation.point_world
    if fixation.origin_world is not None:
        ray = fixation.point_world - fixation.origin_world
        ray = ray / max(float(np.linalg.norm(ray)), 1e-9)
        off = off - ray * (off @ ray)
    return float(off @ np.linalg.solve(cov, off)) < _GATE_SIGMAS**2
