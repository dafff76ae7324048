"""From the grounded plan to the times and places at which its targets can be pictured."""

from collections.abc import Sequence

import numpy as np

from grounding.glide.read import Candidate
from grounding.patches.cut import PatchConfig, Showing
from grounding.plan import GroundedInstruction, GroundedPlan
from grounding.types import FixationObservation, FloatArray, ObjectInstance, RestingPlace

_GATE_SIGMAS = 3.0
_LEAST_S = 0.5  # a shorter stretch is no showing if there is another
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
        the target somewhere, after it; the other one where it stands on or under another thing.
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
    session = (min(f.start_ns for f in fixations), max(f.end_ns for f in fixations))
    thing = next((o for o in objects if o.object_id == best.object_id), None)
    places = _places(each, best, thing, since_ns=session[0])
    size = best.size_m if best.size_m is not None else np.full(3, config.unseen_size_m)
    stretches = []
    for place in places:
        others = [o for o in objects if o.object_id != best.object_id]
        busy = [_near(o, r, place, size) for o in others for r in o.track]
        stretches.append(_longest_free(_standing(place, session, config), busy))
    least_ns = int(_LEAST_S * 1e9)
    chosen = next((k for k, (a, b) in enumerate(stretches) if b - a >= least_ns), 0)
    if not places:
        return None
    mine = [f for f in fixations if f.fixation_id in set(each.fixations)]
    spots = [best.spot.position_world, *(place.position_world for place in places)]
    return Showing(
        instruction=each.spoken.index,
        symbols=each.spoken.instruction.target,
        weight=min(each.confidence, best.probability),
        object_id=best.object_id,
        position_world=places[chosen].position_world,
        quat_xyzw=places[chosen].quat_xyzw,
        size_m=size,
        since_ns=stretches[chosen][0],
        until_ns=stretches[chosen][1],
        is_looked_at=any(_within_gate(f, spot, size) for f in mine for spot in spots),
    )


def _standing(
    place: RestingPlace, session: tuple[int, int], config: PatchConfig
) -> tuple[int, int]:
    """Return from when to when a thing stands at a place and no hand is at it."""
    since = max(place.t_ns + int(config.after_s * 1e9), session[0])
    if place.left_ns is None:
        return since, session[1]
    return since, place.left_ns - int(config.before_s * 1e9)


def _near(
    other: ObjectInstance, rest: RestingPlace, place: RestingPlace, size_m: FloatArray
) -> tuple[float, float] | None:
    """Return when another thing stands on or under one, so that a picture shows both."""
    apart = float(np.linalg.norm((rest.position_world - place.position_world)[:2]))
    if apart > 0.5 * float(max(size_m[:2]) + max(other.size_m[:2])):
        return None
    above = abs(float(rest.position_world[2] - place.position_world[2]))
    if above < 0.3 * float(size_m[2] + other.size_m[2]):
        return None  # beside it
    return rest.t_ns, np.inf if rest.left_ns is None else rest.left_ns


def _longest_free(
    stretch: tuple[int, int], busy: Sequence[tuple[float, float] | None]
) -> tuple[int, int]:
    """Return the longest part of a stretch of time that no other one overlaps."""
    edges, free = stretch[0], []
    for since, until in sorted(each for each in busy if each is not None):
        free.append((edges, int(min(since, stretch[1]))))
        edges = max(edges, int(min(until, stretch[1])))
    free.append((edges, stretch[1]))
    return max(free, key=lambda part: part[1] - part[0])


def _places(
    each: GroundedInstruction, best: Candidate, thing: ObjectInstance | None, *, since_ns: int
) -> list[RestingPlace]:
    """Return where to picture the target, the best place first: the new one if it was moved."""
    moved = each.location is not None and (
        np.linalg.norm(each.location.position_world - best.spot.position_world) > 1e-6
    )
    goal = each.location if moved and each.location else best.spot
    track = () if thing is None else thing.track
    off = [float(np.linalg.norm(p.position_world - goal.position_world)) for p in track]
    if off and min(off) < 1e-3:
        k = int(np.argmin(off))
        beside = track[k - 1 : k] if moved and k else track[k + 1 : k + 2]
        return [track[k], *beside]
    # Vision did not see it stand there: trust the gaze, and the action's times.
    start = each.end_ns if moved else since_ns
    if start is None:
        return []
    quat = _LEVEL if best.quat_xyzw is None else best.quat_xyzw
    return [
        RestingPlace(
            t_ns=start,
            left_ns=None if moved else each.start_ns,
            position_world=goal.position_world,
            quat_xyzw=quat,
            cov_world=goal.cov_world,
        )
    ]


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
