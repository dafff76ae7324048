"""Objects as they come to rest and leave, frame by frame; nothing later than a frame is used."""

from dataclasses import replace

import numpy as np

from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Body, Cam, Overhead, Pose, World
from gazemap.scene.colours import ColourModel, Neighbour
from gazemap.scene.config import SceneConfig
from gazemap.scene.crops import PosedCamera
from gazemap.scene.foreground import TableView
from gazemap.scene.resting import Known, Resting
from gazemap.scene.same_stack import StackQuestion, StackWatch
from gazemap.scene.sites import Site, SiteTracker
from gazemap.types.frame import Frame
from gazemap.types.scene import ObjectState, SceneObject
from gazemap.types.session import TagLayout

_DEFAULT_OUTLINE = np.array([[-0.6, -0.4], [0.6, 0.4]])
_SAME_SIZE = 0.25  # largest relative difference of sides
_COVER_SLACK_NS = 2_500_000_000  # an arm hides a stack for so long while it is built
_ON_TOP_M = 0.002
_ASTRAY_NS = (1_000_000_000, 20_000_000_000)  # since it left: then a missing thing is looked for
_CARRY_SLACK_NS = 500_000_000  # the moments of leaving and coming are known only so well


class LiveObjects:
    """Things that stand on the table, from the overhead camera and the views of the head camera.

    `add` takes the overhead frames and says what settled or left; `add_view` takes posed head
    frames, without which no height can be told: a thing is reported once enough of them have
    seen it. A mark on the table has no height and is no object.
    """

    def __init__(
        self,
        camera: Camera,
        T_world_overhead: Pose[World, Overhead],
        config: SceneConfig,
        *,
        outline_xy: FloatArray = _DEFAULT_OUTLINE,
        marks: TagLayout | None = None,
        is_rectified: bool = False,
    ) -> None:
        """Start with nothing on the table.

        Args:
            camera: the overhead camera.
            T_world_overhead: where it stands; the support is z = 0.
            config: settings.
            outline_xy: (N, 2) bounds of where objects stand.
            marks: tags that are known to lie flat there.
            is_rectified: whether the frames from above are head frames drawn on the table, in
                which things creep and cannot be measured.
        """
        self._config, self._is_rectified = config, is_rectified
        self._overhead = PosedCamera.of(camera, T_world_overhead, is_overhead=True)
        self._table = TableView(self._overhead, outline_xy, config.foreground)
        self._sites = SiteTracker(self._table, config.sites, follows=is_rectified)
        self._resting: dict[int, Resting] = {}
        self._objects: dict[str, SceneObject] = {}
        self._colours: dict[str, ColourModel] = {}
        tags = () if marks is None else marks.tags
        self._questions: dict[tuple[str, int], StackQuestion] = {}
        self._stacked: list[StackWatch] = []
        self._latest: Frame | None = None
        self._marks_xy = np.array([t.T_world_tag.t[:2] for t in tags]).reshape(-1, 2)
        self._mark_side_m = max((t.size_m for t in tags), default=0.0)

    @property
    def objects(self) -> tuple[SceneObject, ...]:
        """All objects seen so far with their resting places."""
        return tuple(self._objects.values())

    def add(self, frame: Frame) -> list[SceneObject]:
        """Take the next overhead frame; return the objects it showed to have left, or not."""
        self._latest = frame
        lab = self._table.reduce(frame.image)
        changes = self._sites.add(lab, frame.t_ns)
        for site in changes.settled:
            if self._is_mark(site):
                continue
            resting = Resting(site, self._table, self._config.fit)
            if not self._is_rectified:
                resting.look(frame, self._overhead)
            self._resting[site.site_id] = resting
        left = [self._leave(site) for site in changes.left]
        back = [thing for site in changes.back for thing in self._return(site)]
        return [thing for thing in left if thing is not None] + back

    def add_view(
        self, frame: Frame, camera: Camera, T_world_cam: Pose[World, Cam]
    ) -> list[SceneObject]:
        """Take a posed head frame; return the objects that it helped to find or to correct."""
        view = PosedCamera.of(camera, T_world_cam, is_overhead=False)
        changed = []
        for resting in self._resting.values():
            if resting.wants(frame.t_ns) and resting.look(frame, view) and resting.is_due:
                changed += self._settle(resting)
        return changed + self._search_stacks(frame, view)

    def finish(self) -> list[SceneObject]:
        """Fit what has been seen too seldom so far, at the end of a recording."""
        changed = []
        for resting in self._resting.values():
            if resting.is_open_question:
                changed += self._settle(resting)
        return changed + self._answers(list(self._questions.values()))

    def _search_stacks(self, frame: Frame, view: PosedCamera) -> list[SceneObject]:
        """Look for missing things on others of their colour, where they do not stand out."""
        if self._is_rectified or self._latest is None:
            return []
        gone = [w for w in self._stacked if w.look(frame, view, self._config.fit)]
        left = [self._take_off(watch) for watch in gone]
        pairs = {
            (thing.object_id, below.site.site_id): (thing, below)
            for thing in self._objects.values()
            if self._is_astray(thing, frame.t_ns)
            for below in self._like_places(thing)
        }
        self._questions = {
            key: self._questions.get(key) or self._asked(thing, below)
            for key, (thing, below) in pairs.items()
        }
        found = self._answers([q for q in self._questions.values() if q.look(frame, view)])
        return [*(thing for thing in left if thing is not None), *found]

    def _answers(self, questions: list[StackQuestion]) -> list[SceneObject]:
        """Place what is now seen to stand on a thing of its colour; the others are asked anew."""
        changed: list[SceneObject] = []
        for question in questions:
            is_missing = self._objects[question.known.object_id].track[-1].left_ns is not None
            if self._latest is None or not is_missing:
                continue
            is_due = question.renew(self._latest, self._overhead)
            if is_due and question.is_so(self._neighbours(question.resting, [question.below])):
                changed.append(self._put_on(question))
        return changed

    @staticmethod
    def _is_astray(thing: SceneObject, t_ns: int) -> bool:
        left_ns = thing.track[-1].left_ns
        return left_ns is not None and _ASTRAY_NS[0] < t_ns - left_ns < _ASTRAY_NS[1]

    def _like_places(self, thing: SceneObject) -> list[Resting]:
        """Return the places of standing things that look like one that is missing."""
        last = [r for r in self._resting.values() if r.object_id == thing.object_id]
        return [
            r
            for r in self._resting.values()
            if r.object_id and r.fit and r.site.left_ns is None and last and last[-1].looks_like(r)
        ]

    def _asked(self, thing: SceneObject, below: Resting) -> StackQuestion:
        latest = self._latest
        if latest is None:
            raise AssertionError
        question = StackQuestion.asked(
            self._known(thing), below, self._table, self._config.fit, t_ns=latest.t_ns
        )
        question.resting.look(latest, self._overhead)
        return question

    def _put_on(self, question: StackQuestion) -> SceneObject:
        resting = question.resting
        resting.object_id = question.known.object_id
        resting.site.site_id = -1 - len(self._resting)
        self._resting[resting.site.site_id] = resting
        seen_ns = resting.site.first_ns if self._latest is None else self._latest.t_ns
        self._stacked.append(StackWatch(below=question.below, resting=resting, there_ns=seen_ns))
        return self._record(resting)

    def _take_off(self, watch: StackWatch) -> SceneObject | None:
        self._stacked.remove(watch)
        site = watch.resting.site
        site.left_ns = max(watch.left_ns, site.first_ns)
        return self._leave(site)

    def _neighbours(self, resting: Resting, below: list[Resting]) -> tuple[Neighbour, ...]:
        others = [r for r in self._resting.values() if r.site.left_ns is None]
        seen = [r.neighbour_of(resting) for r in others if r not in (resting, *below)]
        return tuple(each for each in seen if each is not None)

    def _is_mark(self, site: Site) -> bool:
        """Whether a site is a tag of the layout and nothing more."""
        plan = self._table.rectangle(site.region.pixels)
        distances = np.linalg.norm(self._marks_xy - plan.centre_xy, axis=1)
        is_there = bool((distances < self._mark_side_m / 2).any())
        return is_there and bool((plan.sides_m < 2 * self._mark_side_m).all())

    def _settle(self, resting: Resting) -> list[SceneObject]:
        """Say whose place it is: of a thing that was carried there, or of a new one."""
        known = self._objects.get(resting.object_id)
        was_carried = known is not None and len(known.track) > 1
        candidates = [known] if known and was_carried else self._away(resting)
        below = self._below(resting)
        resting.neighbours = self._neighbours(resting, below)
        object_id = self._known_there(resting, candidates, below)
        if not object_id and not was_carried and resting.measure():
            if self._is_there_already(resting):
                resting.dismiss()
                return []
            object_id = resting.object_id or self._identify(resting, candidates)
        if not object_id:
            return []
        resting.object_id = object_id
        return [*self._uncovered(below, resting), self._record(resting)]

    def _known_there(
        self, resting: Resting, candidates: list[SceneObject], below: list[Resting]
    ) -> str:
        """Return which known thing came to a place, or an empty string.

        What stood there before is asked last: it seemed to leave when another was put on it.
        """
        covered = {r.object_id for r in below}
        new = [self._known(c) for c in candidates if c.object_id not in covered]
        again = [self._known(c) for c in candidates if c.object_id in covered]
        bases = [0.0, *(r.fit.box.top_m for r in below if r.fit)]
        return resting.place(new, bases) or resting.place(again, bases)

    def _below(self, resting: Resting) -> list[Resting]:
        """Return the places on which a newcomer may stand.

        A thing that was covered may be taken to have left when the newcomer came.
        """
        covered = {s.site_id for s in resting.site.covers}
        since_ns = resting.site.first_ns - _COVER_SLACK_NS
        return [
            r
            for r in self._resting.values()
            if r is not resting
            and r.object_id
            and (r.site.site_id in covered or self._seemed_to_leave(r, resting, since_ns))
        ]

    @staticmethod
    def _seemed_to_leave(below: Resting, above: Resting, since_ns: int) -> bool:
        left_ns = below.site.left_ns
        return left_ns is not None and left_ns > since_ns and below.stands_under(above)

    def _uncovered(self, below: list[Resting], resting: Resting) -> list[SceneObject]:
        """Put back what only seemed to have left when something was put on it."""
        back = [
            r
            for r in below
            if r.fit
            and resting.fit
            and r.site.left_ns is not None
            and r.object_id != resting.object_id
            and abs(resting.fit.box.base_m - r.fit.box.top_m) < _ON_TOP_M
        ]
        for each in back:
            each.site.left_ns = None
        return [self._record(each) for each in back]

    def _identify(self, resting: Resting, away: list[SceneObject]) -> str:
        """Return the carried thing of about the measured size, or a new name."""
        unlike = [(resting.unlikeness(thing.size_m), thing.object_id) for thing in away]
        least, object_id = min(unlike, default=(1.0, ""))
        return object_id if least < _SAME_SIZE else f"object-{len(self._objects) + 1}"

    def _is_there_already(self, resting: Resting) -> bool:
        """Whether a place is that of a thing that stands there under another outline."""
        others = [r for r in self._resting.values() if r is not resting and r.object_id]
        return any(resting.overlaps(r) for r in others if r.site.left_ns is None)

    def _away(self, resting: Resting) -> list[SceneObject]:
        """Return the things that had been carried away when something came to a place."""
        until_ns = resting.site.first_ns + _CARRY_SLACK_NS
        things = [(thing, thing.track[-1].left_ns) for thing in self._objects.values()]
        return [thing for thing, left_ns in things if left_ns is not None and left_ns <= until_ns]

    def _known(self, thing: SceneObject) -> Known:
        return Known(
            object_id=thing.object_id, size_m=thing.size_m, colours=self._colours[thing.object_id]
        )

    def _record(self, resting: Resting) -> SceneObject:
        site, fit = resting.site, resting.fit
        if fit is None:
            raise AssertionError
        state = ObjectState(
            t_ns=site.first_ns,
            left_ns=site.left_ns,
            T_world_body=Pose[World, Body].from_rotvec([0, 0, fit.box.yaw_rad], fit.box.centre),
            cov_world=fit.cov_world,
        )
        known = self._objects.get(resting.object_id)
        track = () if known is None else known.track
        others = tuple(s for s in track if s.t_ns != site.first_ns)
        thing = SceneObject(
            object_id=resting.object_id,
            size_m=fit.box.size_m,
            track=tuple(sorted((*others, state), key=lambda s: s.t_ns)),
            mean_bgr=resting.mean_bgr(),
            size_sigma_m=fit.size_sigma_m,
        )
        self._objects[thing.object_id] = thing
        if resting.colours is not None:
            self._colours[thing.object_id] = resting.colours
        return thing

    def _return(self, site: Site) -> list[SceneObject]:
        """Take back that a thing left; what was taken for it elsewhere is something else."""
        resting = self._resting.get(site.site_id)
        if resting is None or not resting.object_id or resting.fit is None:
            return []
        object_id = resting.object_id
        mistaken = [
            r
            for r in self._resting.values()
            if r.object_id == object_id and r.site.first_ns > site.first_ns
        ]
        first_ns = {r.site.first_ns for r in mistaken}
        thing = self._objects[object_id]
        track = tuple(s for s in thing.track if s.t_ns not in first_ns)
        self._objects[object_id] = replace(thing, track=track)
        changed = [self._record(resting)]
        for each in mistaken:
            each.object_id = ""
            if each.is_buried:
                each.dismiss()
            else:
                changed += self._settle(each)
        return changed

    def _leave(self, site: Site) -> SceneObject | None:
        resting = self._resting.get(site.site_id)
        if resting is None:
            return None
        if not resting.object_id:
            if resting.is_open_question:
                self._settle(resting)
            return self._objects.get(resting.object_id)
        thing = self._objects[resting.object_id]
        track = tuple(
            replace(s, left_ns=site.left_ns) if s.t_ns == site.first_ns else s for s in thing.track
        )
        gone = replace(thing, track=track)
        self._objects[thing.object_id] = gone
        return gone
