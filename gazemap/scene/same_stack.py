"""A thing that was put on another of its own colour.

From above such a stack is one patch that hardly changes, so no new resting place is seen. But the
thing is missing; where it might stand, on each thing that looks like it, views show its sides
above the other's or do not. It leaves as quietly, so views are asked whether it is still there.
"""

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from gazemap.scene.colours import ColourDivision, Neighbour
from gazemap.scene.config import BoxFitConfig
from gazemap.scene.crops import PosedCamera
from gazemap.scene.foreground import TableView
from gazemap.scene.resting import Known, Resting
from gazemap.scene.sites import Site
from gazemap.types.frame import Frame

_VIEWS: Final = 4  # beside the one from above
_SURE: Final = 1.0  # mean log-odds of its colours where the thing is, or is not
_HELD_NS: Final = 250_000_000  # a hand hides a thing before it is taken
_LEAST_VIEWS: Final = 3  # the latest of them: before those the thing may have been on its way


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StackQuestion:
    """Whether a missing thing stands on another.

    Attributes:
        known: the missing thing.
        below: the place of the other.
        resting: the place on it, with its views.
    """

    known: Known
    below: Resting
    resting: Resting

    @staticmethod
    def asked(
        known: Known, below: Resting, table: TableView, config: BoxFitConfig, *, t_ns: int
    ) -> "StackQuestion":
        """Begin to look; nothing was seen yet."""
        beneath = below.site
        site = Site(
            site_id=-1,
            region=beneath.region,
            colours=beneath.colours,
            first_ns=t_ns,
            seen_ns=beneath.seen_ns,
            fresh=beneath.region.pixels,
            covers=[beneath],
        )
        resting = Resting(site, table, config, is_buried=True)
        return StackQuestion(known=known, below=below, resting=resting)

    def look(self, frame: Frame, view: PosedCamera) -> bool:
        """Take one more view; return whether there are enough."""
        self.resting.site.seen_ns = self.below.site.seen_ns
        if self.resting.wants(frame.t_ns):
            self.resting.look(frame, view)
        return self.resting.head_count >= _VIEWS

    def renew(self, frame: Frame, overhead: PosedCamera) -> bool:
        """Keep the latest views alone, with one from above; return whether they are enough.

        What they all show came shortly before the first of them.
        """
        seen_ns = self.resting.look_anew(frame, overhead, keep=_LEAST_VIEWS)
        if len(seen_ns) < _LEAST_VIEWS:
            return False
        self.resting.site.first_ns = seen_ns[0] - (seen_ns[1] - seen_ns[0]) // 2
        return True

    def is_so(self, neighbours: tuple[Neighbour, ...]) -> bool:
        """Whether the views show the thing there, beside what else is in sight."""
        if self.below.fit is None:
            return False
        box = self.below.fit.box
        own = Neighbour(shape=box.shape, is_alike=True)
        self.resting.neighbours = (*neighbours, own)
        if not self.resting.place([self.known], [box.top_m]) or self.resting.fit is None:
            return False
        apart_xy = self.resting.fit.box.centre[:2] - box.centre[:2]
        along, across = np.cos(box.yaw_rad), np.sin(box.yaw_rad)
        within = np.abs(np.array([[along, across], [-across, along]]) @ apart_xy)
        return bool((within < box.size_m[:2] / 2).all())


@dataclass(slots=True, kw_only=True, eq=False)
class StackWatch:
    """A thing that stands on another of its colour, until it is taken.

    Attributes:
        below: the place of the other.
        resting: its own.
        there_ns: when it was last seen there.
        missed_ns: the latest views in which it was not.
    """

    below: Resting
    resting: Resting
    there_ns: int
    missed_ns: list[int] = field(default_factory=list)

    def look(self, frame: Frame, view: PosedCamera, config: BoxFitConfig) -> bool:
        """Take one more view; return whether the thing has left."""
        if self.below.site.left_ns is not None:
            return True
        latest_ns = self.missed_ns[-1] if self.missed_ns else self.there_ns
        is_early = frame.t_ns - latest_ns < config.view_period_s * 1e9
        crop = self.resting.cut(frame, view)
        fit, colours = self.resting.fit, self.resting.colours
        if is_early or crop is None or not self.below.is_in_sight(frame.t_ns) or fit is None:
            return False
        division = ColourDivision([crop], neighbours=self.resting.neighbours)
        odds = division.clarity(fit.box.shape, colours)
        if odds > _SURE:
            self.there_ns, self.missed_ns = frame.t_ns, []
        elif odds < -_SURE:
            self.missed_ns.append(frame.t_ns)
        return len(self.missed_ns) >= _LEAST_VIEWS

    @property
    def left_ns(self) -> int:
        """When it was taken, if it was."""
        return min([self.there_ns + _HELD_NS, *self.missed_ns])
