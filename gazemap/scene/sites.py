"""Places at which something rests, followed through the images of the fixed camera.

A site is a patch that is not table and has stood still for a while. It stays open while it looks
as it did, or while something covers it; it is closed once the table shows through, or what it
covered is seen again.
"""

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray, IntArray
from gazemap.scene.config import SiteConfig
from gazemap.scene.foreground import Region, TableView
from gazemap.scene.passing import SAME_COLOUR, SeenFrame, arrival_ns, leaving_ns

_AREA_RATIO = 1.3
_MIN_FRESH = 8
_UNCHANGED = 0.8  # share of a site's pixels that look as before while nothing is put upon it


@dataclass(slots=True, kw_only=True, eq=False)
class Site:
    """A place at which something rests.

    Attributes:
        site_id: in the order of appearance.
        region: the patch when it was found.
        colours: (N, 3) how its pixels looked then, CIELAB.
        first_ns: when the thing came there.
        seen_ns: when it was last recognised.
        left_ns: when it left, or None.
        covers: the sites that it hides, wholly or in part.
        fresh: (M,) those of its pixels that do not look as what it covers did.
        is_settled: whether it stood still long enough.
        empty_ns: since when it is nothing but unchanged table, or None.
    """

    site_id: int
    region: Region
    colours: FloatArray
    first_ns: int
    seen_ns: int
    left_ns: int | None = None
    covers: "list[Site]" = field(default_factory=list)
    fresh: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    is_settled: bool = False
    empty_ns: int | None = None

    def see(self, t_ns: int) -> None:
        """Note that the thing is still there."""
        self.seen_ns, self.empty_ns = t_ns, None

    def same(self, lab: ImageArray) -> float:
        """Return the share of its pixels that look as they did."""
        return float(self.unchanged(lab).mean())

    def unchanged(self, lab: ImageArray) -> BoolArray:
        """Return which of its pixels (N,) look as they did."""
        now = lab.reshape(-1, 3)[self.region.pixels].astype(np.float64)
        return np.asarray(np.linalg.norm(now - self.colours, axis=1) < SAME_COLOUR)

    def shares(self, other: "Site") -> float:
        """Return the share of the smaller patch that lies in the other."""
        both = len(np.intersect1d(self.region.pixels, other.region.pixels))
        return both / min(len(self.region.pixels), len(other.region.pixels))

    def bare(self, stands_out: BoolArray) -> float:
        """Return the share of its pixels that look like the table."""
        return 1.0 - float(stands_out.ravel()[self.region.pixels].mean())


@dataclass(slots=True, kw_only=True, eq=False)
class SiteChanges:
    """What one frame changed: sites that settled, that were left, or only seemed to be left."""

    settled: list[Site] = field(default_factory=list)
    left: list[Site] = field(default_factory=list)
    back: list[Site] = field(default_factory=list)


class SiteTracker:
    """Follows the resting places through the frames of the fixed camera."""

    def __init__(self, table: TableView, config: SiteConfig, *, follows: bool = False) -> None:
        """Start with nothing known about the table; follow patches that creep, if asked to."""
        self._table, self._config, self._follows = table, config, follows
        self._open: list[Site] = []
        self._left: list[Site] = []
        self._history: deque[SeenFrame] = deque()
        self._count = 0

    def add(self, lab: ImageArray, t_ns: int) -> SiteChanges:
        """Take the next reduced image (h, w, 3)."""
        stands_out = self._table.stands_out(lab)
        seen = SeenFrame(t_ns=t_ns, lab=self._table.levelled(lab), stands_out=stands_out)
        self._history.append(seen)
        while t_ns - self._history[0].t_ns > self._config.history_s * 1e9:
            self._history.popleft()
        changes = SiteChanges()
        for site in self._match(self._table.regions(seen.stands_out), seen, changes):
            self._look_again(site, seen, changes)
        self._left += changes.left
        self._open = [s for s in self._open if s.left_ns is None]
        return changes

    def _match(self, regions: list[Region], seen: SeenFrame, changes: SiteChanges) -> list[Site]:
        """Recognise sites by their patches; return those that were not."""
        unseen = list(self._open)
        for region in regions:
            alike = [s for s in unseen if self._is_alike(s, region, seen)]
            site = min(alike, key=lambda s: _distance(s.region, region), default=None)
            if site is None:
                again = self._again(region, seen, changes)
                self._open.append(again or self._new_site(region, seen))
                continue
            unseen.remove(site)
            if self._follows:
                site.region, site.colours = region, seen.at(region.pixels)
            self._recognise(site, seen, changes)
        return [s for s in unseen if s.left_ns is None]

    def _is_alike(self, site: Site, region: Region, seen: SeenFrame) -> bool:
        """Whether a patch is a known site: in outline, and with nothing new upon it."""
        return self._is_same(site.region, region) and site.same(seen.lab) > _UNCHANGED

    def _is_same(self, known: Region, new: Region) -> bool:
        close = _distance(known, new) * self._table.pixel_m < self._config.max_shift_m
        ratio = len(new.pixels) / len(known.pixels)
        return close and 1 / _AREA_RATIO < ratio < _AREA_RATIO

    def _new_site(self, region: Region, seen: SeenFrame) -> Site:
        self._count += 1
        return Site(
            site_id=self._count,
            region=region,
            colours=seen.at(region.pixels),
            first_ns=seen.t_ns,
            seen_ns=seen.t_ns,
        )

    def _again(self, region: Region, seen: SeenFrame, changes: SiteChanges) -> Site | None:
        """Return the site that was taken for empty, but looks as it did: an arm deceived us."""
        for site in self._left:
            if self._is_alike(site, region, seen):
                self._left.remove(site)
                site.left_ns = None
                site.see(seen.t_ns)
                changes.back.append(site)
                return site
        return None

    def _recognise(self, site: Site, seen: SeenFrame, changes: SiteChanges) -> None:
        site.see(seen.t_ns)
        if site.is_settled:
            self._uncover(site, changes)
        elif seen.t_ns - site.first_ns >= self._config.settle_s * 1e9:
            self._settle(site, seen, changes)

    def _uncover(self, site: Site, changes: SiteChanges) -> None:
        """What is seen again as it was is no longer covered: what covered it has left."""
        for above in self._open:
            if above.is_settled and above.left_ns is None and site in above.covers:
                self._close(above, changes)

    def _settle(self, site: Site, seen: SeenFrame, changes: SiteChanges) -> None:
        touched = [s for s in self._open if s.is_settled and s.left_ns is None]
        site.covers = [s for s in touched if _overlap(s.region, site.region) > 0.3]
        if any(self._is_grown(below, site, seen) for below in site.covers):
            site.left_ns = seen.t_ns
            return
        site.is_settled = True
        site.fresh = _fresh_pixels(site, seen)
        site.colours = seen.at(site.region.pixels)
        came_ns = arrival_ns(site.region.pixels, site.colours, self._history)
        site.first_ns = self._history[0].t_ns if came_ns is None else came_ns
        changes.settled.append(site)

    def _is_grown(self, known: Site, new: Site, seen: SeenFrame) -> bool:
        """Whether a patch is a known site with a little more around it, such as a shadow."""
        extra = 1 - _overlap(new.region, known.region)
        if known.same(seen.lab) < _UNCHANGED or extra > 0.35:
            return False
        known.seen_ns = seen.t_ns
        return True

    def _is_intact(self, site: Site, seen: SeenFrame) -> bool:
        looks_same = site.same(seen.lab) >= self._config.min_same
        return looks_same and site.bare(seen.stands_out) < self._config.max_bare

    def _close(self, site: Site, changes: SiteChanges) -> None:
        left_ns = leaving_ns(site.region.pixels, site.colours, self._history)
        site.left_ns = max(site.seen_ns if left_ns is None else left_ns, site.first_ns)
        changes.left.append(site)

    def _look_again(self, site: Site, seen: SeenFrame, changes: SiteChanges) -> None:
        """Decide about a site whose patch was not found: hidden, gone, or never at rest."""
        if not site.is_settled:
            site.left_ns = seen.t_ns
            return
        if self._is_intact(site, seen):
            site.see(seen.t_ns)
            return
        is_bare = site.bare(seen.stands_out) >= self._config.min_bare
        if not (is_bare and self._is_unchanged(site)):
            site.empty_ns = None
            return
        site.empty_ns = site.empty_ns or seen.t_ns
        if seen.t_ns - site.empty_ns >= self._config.empty_s * 1e9:
            self._close(site, changes)

    def _is_unchanged(self, site: Site) -> bool:
        """Whether a place looks as in the frame before: an arm of the table's colour moves."""
        if len(self._history) < 2:
            return False
        now, before = (self._history[k].lab.reshape(-1, 3)[site.region.pixels] for k in (-1, -2))
        change = np.abs(now.astype(np.float64) - before).mean()
        return bool(change < self._config.max_change)


def _fresh_pixels(site: Site, seen: SeenFrame) -> IntArray:
    """Return which of a site's pixels are new; all of them where hardly any are."""
    old = [s.region.pixels[s.unchanged(seen.lab)] for s in site.covers]
    fresh = np.setdiff1d(site.region.pixels, np.concatenate(old)) if old else site.region.pixels
    return fresh if len(fresh) >= _MIN_FRESH else site.region.pixels


def _distance(a: Region, b: Region) -> float:
    return float(np.linalg.norm(a.centroid_px - b.centroid_px))


def _overlap(part: Region, whole: Region) -> float:
    """Return the share of one region's pixels that lie in another."""
    return float(np.isin(part.pixels, whole.pixels).mean())
