"""Align sessions of any length: long ones in overlapping windows of instructions.

The cost of exact inference grows with looks times instructions times resting places. A window of
some thirty instructions knows all that matters for the first two thirds of them; those are kept,
and the next window begins where the last of them ended.
"""

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from grounding.glide.actions import Kind, elementary_actions, whole_episodes
from grounding.glide.align import Alignment, align
from grounding.glide.config import GlideConfig, Inference
from grounding.glide.model import Demonstration
from grounding.glide.modes import align_all_modes
from grounding.glide.read import InstructionBelief, LookBelief
from grounding.types import FixationObservation, ObjectInstance

_MOTION_SLACK_S = 20.0  # movements this long before and after a window's looks still count
_SPARE_S = 1.0  # looks this long after the next window's first words, or the last movement
_SPARE = 1.1  # with neither: looks taken beyond a window's fair share

V = TypeVar("V")


@dataclass(frozen=True, slots=True, kw_only=True)
class Window:
    """Instructions first to past - 1, of which those before `kept` stay, and their looks.

    `is_guessed` says that nothing but their number tells which looks are theirs.
    """

    first: int
    kept: int
    past: int
    first_look: int
    past_look: int
    is_guessed: bool = False


def align_session(
    demonstration: Demonstration,
    config: GlideConfig | None = None,
    *,
    rng: np.random.Generator | None = None,
) -> Alignment:
    """Align a session that is over, of any length; see `align` for the arguments.

    Returns:
        The alignment; of a long session the parameters are those of the last window.
    """
    config = config or GlideConfig()
    count = len(demonstration.spoken)
    if count <= config.window:
        return _align(demonstration, config, open_end=False, rng=rng)
    fixations = sorted(demonstration.fixations, key=lambda f: (f.start_ns, f.fixation_id))
    looks: list[LookBelief] = []
    beliefs: list[InstructionBelief] = []
    evidence, part = 0.0, None
    fits: list[float] = []
    while len(beliefs) < count:
        window = _window(demonstration, fixations, config, first=len(beliefs), look=len(looks))
        is_last = window.past == count
        part = _align(
            cut(demonstration, fixations, window),
            config,
            open_end=window.is_guessed,
            rng=rng,
        )
        kept = part.instructions[: window.kept - window.first]
        beliefs += kept
        labelled = len(part.looks) if is_last else looks_until(kept, part, fixations, window)
        looks += part.looks[:labelled]
        evidence += part.log_evidence
        fits.append(part.fit)
    return Alignment(
        looks=tuple(looks),
        instructions=tuple(beliefs),
        log_evidence=evidence,
        fit=float(np.median(fits)),
        parameters=part.parameters if part else None,
        effective_samples=part.effective_samples if part else None,
    )


def first_window(demonstration: Demonstration, config: GlideConfig) -> Demonstration:
    """Return the first instructions that are aligned at once, with their looks and movements."""
    if len(demonstration.spoken) <= config.window:
        return demonstration
    fixations = sorted(demonstration.fixations, key=lambda f: (f.start_ns, f.fixation_id))
    window = _window(demonstration, fixations, config, first=0, look=0)
    return cut(demonstration, fixations, window)


def _align(
    demonstration: Demonstration,
    config: GlideConfig,
    *,
    open_end: bool,
    rng: np.random.Generator | None,
) -> Alignment:
    """Align one window; once the session is over, other explanations are tried."""
    as_said = align(demonstration, config, open_end=open_end, rng=rng)
    if open_end or config.inference is not Inference.EXACT:
        return as_said
    return align_all_modes(
        demonstration,
        lambda changed: align(changed, config),
        prior=config.exchanged_prior,
        as_said=as_said,
    )


def _window(
    demonstration: Demonstration,
    fixations: Sequence[FixationObservation],
    config: GlideConfig,
    *,
    first: int,
    look: int,
) -> Window:
    count, total = len(demonstration.spoken), len(fixations)
    past = min(first + config.window, count)
    if past == count:
        return Window(first=first, kept=count, past=count, first_look=look, past_look=total)
    until_ns = demonstration.spoken[past].said_start_ns
    if until_ns is None and look < total:
        begin_ns = fixations[look].start_ns
        until_ns = _last_movement_ns(demonstration, begin_ns, first=first, past=past)
    if until_ns is not None:
        until_ns += round(_SPARE_S * 1e9)
        past_look = sum(1 for each in fixations if each.start_ns < until_ns)
    else:
        past_look = look + round(_SPARE * (total - look) * (past - first) / (count - first))
    kept = first + whole_episodes(demonstration.spoken[first:], 2 * (past - first) // 3)
    return Window(
        first=first,
        kept=kept,
        past=past,
        first_look=look,
        past_look=min(max(past_look, look + 1), total),
        is_guessed=until_ns is None,
    )


def _last_movement_ns(
    demonstration: Demonstration, begin_ns: int, *, first: int, past: int
) -> int | None:
    """Return when the last thing that these instructions move came to rest, if vision saw it."""
    acts = elementary_actions(demonstration.spoken[first:past])
    moves = sum(1 for act in acts if act.kind is Kind.PUT)
    arrivals = sorted(
        place.t_ns
        for thing in demonstration.objects
        for place in thing.track[1:]
        if place.t_ns > begin_ns
    )
    return arrivals[moves - 1] if 0 < moves <= len(arrivals) else None


def cut(
    demonstration: Demonstration, fixations: Sequence[FixationObservation], window: Window
) -> Demonstration:
    """Return what a window's instructions, looks, and movements about them are."""
    mine = fixations[window.first_look : window.past_look]
    slack_ns = round(_MOTION_SLACK_S * 1e9)
    begin_ns = mine[0].start_ns - slack_ns if mine else 0
    end_ns = mine[-1].end_ns + slack_ns if mine else 0
    near = [_near(each, begin_ns, end_ns) for each in demonstration.objects]
    return dataclasses.replace(
        demonstration,
        spoken=demonstration.spoken[window.first : window.past],
        fixations=mine,
        objects=[each for each in near if each is not None],
        meant=_shifted(demonstration.meant, window),
        not_meant=_shifted(demonstration.not_meant, window),
    )


def _near(thing: ObjectInstance, begin_ns: int, end_ns: int) -> ObjectInstance | None:
    """Return a thing with the resting places that it had in a stretch of time."""
    track = tuple(
        place
        for place in thing.track
        if place.t_ns <= end_ns and (place.left_ns is None or place.left_ns >= begin_ns)
    )
    return dataclasses.replace(thing, track=track) if track else None


def _shifted(told: Mapping[int, V], window: Window) -> dict[int, V]:
    return {i - window.first: value for i, value in told.items() if window.first <= i < window.past}


def looks_until(
    kept: Sequence[InstructionBelief],
    part: Alignment,
    fixations: Sequence[FixationObservation],
    window: Window,
) -> int:
    """Return how many of the window's looks lie before the end of the last kept instruction."""
    ends = [each.end_ns for each in kept if each.end_ns is not None]
    if not ends:
        return 0
    mine = fixations[window.first_look : window.first_look + len(part.looks)]
    return sum(1 for each in mine if each.end_ns <= max(ends))
