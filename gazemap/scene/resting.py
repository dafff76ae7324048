"""One resting place under examination: its views, and the box that they show."""

from dataclasses import dataclass, replace

import numpy as np

from gazemap.geometry.arrays import FloatArray, IntArray
from gazemap.scene.box_fit import Box, BoxFit, fit_boxes, fit_flat, fit_place
from gazemap.scene.colours import ColourDivision, ColourModel, Neighbour
from gazemap.scene.config import BoxFitConfig
from gazemap.scene.crops import Crop, PosedCamera, cut_out
from gazemap.scene.foreground import TableView
from gazemap.scene.sites import Site
from gazemap.types.frame import Frame

_ROOM_M = 0.11  # how much of the table is seen around a thing
_LOOK_M = 0.015  # the height that cut-outs look at
_IN_SIGHT_S = 0.2
_PLACE_YAWS = np.arange(6) * np.pi / 6
_FLAT_M = 0.004
_DOUBTFUL = 2.0
_SHARED_ROOM = 0.15
_LARGER = 1.3
_AT_LIMIT = 0.97
_USUAL_HEIGHT_M = 0.035
_SAME_PATCH = 0.1
_SPECK_M2 = 5e-4
_SPECK_CLEARER = 1.4
_LIGHT_COUNTS_LESS = np.array([0.5, 1.0, 1.0])  # of 8-bit CIELAB: sides are darker than tops
_ALIKE = 25.0
_KNOWN_CLARITY = 0.6  # another heading shows other sides: a known thing may be less clear


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Known:
    """What is known of a thing from an earlier place."""

    object_id: str
    size_m: FloatArray
    colours: ColourModel


class Resting:
    """A settled site with what the cameras saw of it.

    Attributes:
        site: the resting place.
        object_id: whose place it is; empty while unknown or where there is no volume.
        fit: the box, once there is one.
        colours: the thing's colours, once there is a box.
        is_flat: whether it is known to be a mark on the table.
        is_buried: whether it does not stand out of another thing's patch, which is its own then.
        centre_world: (3,) the point that the cut-outs look at.
        neighbours: other things, which may stand before it or look the same.
    """

    def __init__(
        self, site: Site, table: TableView, config: BoxFitConfig, *, is_buried: bool = False
    ) -> None:
        """Start without any view."""
        self.site, self._table, self._config, self.is_buried = site, table, config, is_buried
        self.object_id = ""
        self.fit: BoxFit | None = None
        self.colours: ColourModel | None = None
        self.is_flat = False
        plan = table.rectangle(site.fresh)
        self.centre_world = np.array([*plan.centre_xy, _LOOK_M])
        self._span_m = float(plan.sides_m.max()) + _ROOM_M
        self._crops: list[Crop] = []
        self.neighbours: tuple[Neighbour, ...] = ()
        self._measured: tuple[int, int, int] | None = None

    @property
    def _head_crops(self) -> list[Crop]:
        return [c for c in self._crops if not c.is_overhead]

    def wants(self, t_ns: int) -> bool:
        """Whether another view at this time would help."""
        heads = self._head_crops
        is_late = not heads or t_ns - heads[-1].t_ns >= self._config.view_period_s * 1e9
        is_open = self.site.left_ns is None and not self.is_flat
        is_wanted = is_open and is_late and len(heads) < self._config.max_views
        return is_wanted and self.is_in_sight(t_ns)

    def is_in_sight(self, t_ns: int) -> bool:
        """Whether the place was recognised from above just now."""
        return t_ns - self.site.seen_ns < _IN_SIGHT_S * 1e9

    def cut(self, frame: Frame, view: PosedCamera) -> Crop | None:
        """Return what a view sees of the place, or None where that is not in it."""
        return cut_out(
            frame,
            view,
            centre_world=self.centre_world,
            span_m=self._span_m,
            size_px=self._config.crop_px,
        )

    def look(self, frame: Frame, view: PosedCamera) -> bool:
        """Take one more view; return whether the place lies in it."""
        crop = self.cut(frame, view)
        if crop is not None:
            self._crops.append(crop)
        return crop is not None

    def look_anew(self, frame: Frame, view: PosedCamera, *, keep: int) -> list[int]:
        """Replace the view from above; forget all but the latest few of the head camera.

        Returns:
            The times of those.
        """
        self._crops, heads = [], self._head_crops[-keep:]
        self.look(frame, view)
        self._crops += heads
        return [c.t_ns for c in heads]

    @property
    def head_count(self) -> int:
        """How many views of the head camera there are."""
        return len(self._head_crops)

    @property
    def is_due(self) -> bool:
        """Whether the views just became enough for a first or a better fit."""
        return self.head_count in (self._config.min_views, self._config.max_views)

    @property
    def is_open_question(self) -> bool:
        """Whether there are views but no verdict."""
        return not self.object_id and not self.is_flat and bool(self._head_crops)

    def measure(self) -> bool:
        """Fit a box on the table; return whether there is a volume.

        What was seen no better than the last time is not measured again.
        """
        alike = sum(each.is_alike for each in self.neighbours)
        known = len(self._crops), len(self.neighbours), alike
        if known == self._measured:
            return self.fit is not None
        self._measured = known
        division = ColourDivision(self._crops, neighbours=self.neighbours)
        fits = self._fits(division, self._starts(self.site.fresh))
        best = max(fits, key=_likelihood)
        if self.fit is None and division.clarity(best.box.shape) < _DOUBTFUL:
            # A mark or shadow beside a thing is one patch with it: start from its parts as well.
            starts = [s for part in self._parts() for s in self._starts(part)]
            fits += self._fits(division, starts)
        return self._accept(division, max(fits, key=_likelihood))

    def _fits(self, division: ColourDivision, starts: list[Box]) -> list[BoxFit]:
        """Return the boxes near some starts, none longer than the patch in the view from above."""
        return fit_boxes(division, starts, self._limits)

    @property
    def _limits(self) -> BoxFitConfig:
        longest_m = _LARGER * float(self._table.rectangle(self.site.fresh).sides_m.max())
        return replace(self._config, max_plan_m=min(longest_m, self._config.max_side_m))

    def _accept(self, division: ColourDivision, fit: BoxFit) -> bool:
        box = fit.box
        is_clear = division.clarity(box.shape) >= self._least_clarity
        self.is_flat = is_clear and box.size_m[2] < _FLAT_M
        is_thing = is_clear and self._is_solid(box) and self._is_here(division, box)
        if not (is_thing and self._stands(division, fit)):
            return False
        self.fit, self.colours = fit, division.model(box.shape)
        return True

    @property
    def _least_clarity(self) -> float:
        """What is said early must be beyond doubt, and so must a thing no larger than a speck."""
        least = self._config.min_clarity
        if self._area_m2 < _SPECK_M2:
            least *= _SPECK_CLEARER
        is_early = len(self._head_crops) < self._config.max_views
        return max(least, _DOUBTFUL) if is_early else least

    @property
    def _area_m2(self) -> float:
        return len(self.site.fresh) * self._table.pixel_m**2

    def _is_solid(self, box: Box) -> bool:
        thinnest_m, height_m, config = (
            float(box.size_m[:2].min()),
            float(box.size_m[2]),
            self._config,
        )
        is_large = height_m >= config.min_height_m and thinnest_m >= config.min_side_m
        if box.size_m[:2].max() > _AT_LIMIT * self._limits.max_plan_m:
            return False  # it would be larger if it might: what it divides is no thing
        return is_large and height_m <= config.max_slenderness * thinnest_m

    def _stands(self, division: ColourDivision, fit: BoxFit) -> bool:
        """Whether the height explains what is seen that no mark on the table does."""
        flat = fit_flat(division, fit.box, self._limits)
        gain = fit.log_likelihood - flat.log_likelihood
        return gain > self._config.min_gain * float(division.masks(fit.box.shape).sum())

    def _is_here(self, division: ColourDivision, box: Box) -> bool:
        """Whether the box covers the middle of its patch and is about as large as that.

        The patch of what stands on another may have that other in it.
        """
        mask = division.masks(box.shape)[0]
        middle = division.size_px // 2  # cut-outs look at the middle of the patch
        if not mask[middle, middle]:
            return False
        if self.is_buried:
            return True
        covered = mask.mean() * self._span_m**2
        most = 2.5 if box.base_m < _FLAT_M else np.inf
        return bool(0.4 < self._area_m2 / max(covered, 1e-9) < most)

    def _starts(self, pixels: IntArray) -> list[Box]:
        plan = self._table.rectangle(pixels)
        flat = Box(
            centre=np.array([*plan.centre_xy, 0.0]),
            yaw_rad=plan.yaw_rad,
            size_m=np.array([*plan.sides_m, 0.0]),
        )
        return [flat.standing_on(0.0, h) for h in self._config.start_heights_m]

    def _parts(self) -> list[IntArray]:
        """Split the patch into two by colour."""
        colours, pixels = self.site.colours, self.site.region.pixels
        main = np.linalg.svd(colours - colours.mean(axis=0), full_matrices=False)[2][0]
        along = colours @ main
        cut = (along.min() + along.max()) / 2
        parts = [pixels[along < cut], pixels[along >= cut]]
        return [p for p in parts if len(p) >= 8]

    def place(self, candidates: list[Known], bases_m: list[float]) -> str:
        """Find out which known thing came here, and on which level it stands.

        Returns:
            Its name, or an empty string where none explains what is seen.
        """
        division = ColourDivision(self._crops, neighbours=self.neighbours)
        best: tuple[Known, BoxFit] | None = None
        for known in candidates:
            fit = fit_place(
                division, self._place_starts(known, bases_m), self._config, known.colours
            )
            if not self._is_known(division, known, fit):
                continue
            if best is None or fit.log_likelihood > best[1].log_likelihood:
                best = (known, fit)
        if best is None:
            return ""
        self.fit, self.colours = best[1], best[0].colours
        return best[0].object_id

    def _place_starts(self, known: Known, bases_m: list[float]) -> list[Box]:
        plan = self._table.rectangle(self.site.fresh)
        return [
            Box(
                centre=np.array([*plan.centre_xy, base + known.size_m[2] / 2]),
                yaw_rad=plan.yaw_rad + yaw,
                size_m=known.size_m,
            )
            for base in bases_m
            for yaw in _PLACE_YAWS
        ]

    def _is_known(self, division: ColourDivision, known: Known, fit: BoxFit) -> bool:
        """Whether the views show the known thing's colours where its box was placed."""
        least = _KNOWN_CLARITY * self._config.min_clarity
        is_clear = division.clarity(fit.box.shape, known.colours) >= least
        return is_clear and self._is_here(division, fit.box)

    def unlikeness(self, size_m: FloatArray) -> float:
        """Return by how much the measured sides differ from a known thing's, relatively."""
        if self.fit is None:
            return float("inf")
        measured, known = np.sort(self.fit.box.size_m), np.sort(size_m)
        return float(np.abs(np.log(measured / known)).max())

    def neighbour_of(self, other: "Resting") -> Neighbour | None:
        """Return this place as what another's cut-outs show beside it.

        While its height is unknown, it is left out of them only where it would be mistaken.
        """
        is_alike = self.looks_like(other)
        if self.fit is not None and self.object_id:
            return Neighbour(shape=self.fit.box.shape, is_alike=is_alike)
        is_thing = not self.is_flat and self._area_m2 > _SPECK_M2
        if not (is_alike and is_thing) or self.site.shares(other.site) > _SAME_PATCH:
            return None
        flat = self._starts(self.site.fresh)[0]
        return Neighbour(shape=flat.standing_on(0.0, _USUAL_HEIGHT_M).shape, is_alike=True)

    def looks_like(self, other: "Resting") -> bool:
        """Whether two patches are of about one colour."""
        apart = self.site.colours.mean(axis=0) - other.site.colours.mean(axis=0)
        return bool(np.linalg.norm(apart * _LIGHT_COUNTS_LESS) < _ALIKE)

    def stands_under(self, other: "Resting") -> bool:
        """Whether the middle of another place lies over this one's box."""
        if self.fit is None:
            return False
        apart = np.linalg.norm(self.fit.box.centre[:2] - other.centre_world[:2])
        return bool(apart < 0.5 * self.fit.box.size_m[:2].min())

    def overlaps(self, other: "Resting") -> bool:
        """Whether two fitted boxes share more room than errors of their sides explain."""
        if self.fit is None or other.fit is None:
            return False
        mine, theirs = self.fit.box, other.fit.box
        least_m3 = min(float(box.size_m.prod()) for box in (mine, theirs))
        return mine.shared_m3(theirs) > _SHARED_ROOM * least_m3

    def dismiss(self) -> None:
        """Take the place for nothing of its own."""
        self.fit, self.is_flat = None, True

    def mean_bgr(self) -> FloatArray:
        """Return the thing's mean colour (3,)."""
        if self.fit is None:
            return np.zeros(3)
        crop = self._crops[0]
        inside = ColourDivision(self._crops[:1]).masks(self.fit.box.shape)[0] & crop.valid
        return np.asarray(crop.image[inside].mean(axis=0)) if inside.any() else np.zeros(3)


def _likelihood(fit: BoxFit) -> float:
    return fit.log_likelihood
