"""Alignment while a session goes on: what is over and settled is kept, the rest is inferred anew.

Each update costs what the last `live_window` instructions and their looks cost, however long the
session. The model is that of `align`; when the session is over it is aligned as a whole.
"""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grounding.glide.actions import whole_episodes
from grounding.glide.align import Alignment, align
from grounding.glide.config import GlideConfig
from grounding.glide.model import Demonstration
from grounding.glide.read import InstructionBelief, LookBelief
from grounding.glide.windows import Window, cut, looks_until
from grounding.types import FixationObservation, SpokenInstruction


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Settled:
    """The instructions that are over, with what they were inferred from.

    Attributes:
        spoken: the instructions.
        told: what a human had said of them.
        fixations: the looks before the end of the last.
        beliefs: of each instruction.
        looks: of each look.
        fits: of the windows they were inferred in.
        log_evidence: of those windows.
    """

    spoken: tuple[SpokenInstruction, ...] = ()
    told: tuple[object, ...] = ()
    fixations: tuple[int, ...] = ()
    beliefs: tuple[InstructionBelief, ...] = ()
    looks: tuple[LookBelief, ...] = ()
    fits: tuple[float, ...] = ()
    log_evidence: float = 0.0


class Follower:
    """Aligns a growing session; a correction of what is settled unsettles it."""

    def __init__(self) -> None:
        """Begin with nothing settled."""
        self._settled = _Settled()

    def align(self, demonstration: Demonstration, config: GlideConfig) -> Alignment:
        """Align a session that goes on; see `align`."""
        fixations = sorted(demonstration.fixations, key=lambda f: (f.start_ns, f.fixation_id))
        if not self._still_holds(demonstration, fixations):
            self._settled = _Settled()
        part, window = self._open_part(demonstration, fixations, config)
        whole = self._with_settled(part)
        if window.past - window.first > config.live_window:
            self._settle(demonstration, fixations, part, window)
        return whole

    def _still_holds(
        self, demonstration: Demonstration, fixations: Sequence[FixationObservation]
    ) -> bool:
        settled = self._settled
        count = len(settled.spoken)
        return (
            tuple(demonstration.spoken[:count]) == settled.spoken
            and _told(demonstration, count) == settled.told
            and _ids(fixations[: len(settled.fixations)]) == settled.fixations
        )

    def _open_part(
        self,
        demonstration: Demonstration,
        fixations: Sequence[FixationObservation],
        config: GlideConfig,
    ) -> tuple[Alignment, Window]:
        window = Window(
            first=len(self._settled.spoken),
            kept=len(demonstration.spoken),
            past=len(demonstration.spoken),
            first_look=len(self._settled.fixations),
            past_look=len(fixations),
        )
        return align(cut(demonstration, fixations, window), config, open_end=True), window

    def _with_settled(self, part: Alignment) -> Alignment:
        settled = self._settled
        return dataclasses.replace(
            part,
            looks=settled.looks + part.looks,
            instructions=settled.beliefs + part.instructions,
            log_evidence=settled.log_evidence + part.log_evidence,
            fit=float(np.median([*settled.fits, part.fit])),
        )

    def _settle(
        self,
        demonstration: Demonstration,
        fixations: Sequence[FixationObservation],
        part: Alignment,
        window: Window,
    ) -> None:
        """Keep the first third of the open instructions, as far as they ended."""
        open_ones = demonstration.spoken[window.first :]
        kept = part.instructions[: whole_episodes(open_ones, len(open_ones) // 3)]
        looks = looks_until(kept, part, fixations, window)
        if not kept or kept[-1].end_ns is None or not looks:
            return
        settled, count = self._settled, window.first + len(kept)
        self._settled = _Settled(
            spoken=tuple(demonstration.spoken[:count]),
            told=_told(demonstration, count),
            fixations=_ids(fixations[: window.first_look + looks]),
            beliefs=settled.beliefs + kept,
            looks=settled.looks + part.looks[:looks],
            fits=(*settled.fits, part.fit),
            log_evidence=settled.log_evidence + part.log_evidence * looks / len(part.looks),
        )


def _ids(fixations: Sequence[FixationObservation]) -> tuple[int, ...]:
    return tuple(each.fixation_id for each in fixations)


def _told(demonstration: Demonstration, count: int) -> tuple[object, ...]:
    """Return what a human said of the first instructions."""
    return tuple(
        (i, demonstration.meant.get(i), demonstration.not_meant.get(i))
        for i in range(count)
        if i in demonstration.meant or i in demonstration.not_meant
    )
