"""The decisive step: points found again by fixed patches in every frame, and a final adjustment."""

from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.ports import Progress
from gazemap.slam.bundle import BundleProblem, adjust
from gazemap.slam.config import SlamConfig
from gazemap.slam.focal import estimate_focal, with_focal
from gazemap.slam.frame_path import FramePath, shutter_shift
from gazemap.slam.framewise import FrameViews, pose_frames
from gazemap.slam.front import Skeleton
from gazemap.slam.moving_frames import MovingFrames
from gazemap.slam.patch_choice import PatchPoints, candidate_points, choose_found
from gazemap.slam.patches import PatchAtlas, PatchViews
from gazemap.slam.rolling_shutter import estimate_readout
from gazemap.slam.structure import Structure
from gazemap.slam.video import GreyVideo

_OUTLIER_PX = 2.0
_FEWEST_KEYFRAMES = 3
_WIDE_THEN_NARROW = (4.0, 1.0)
_NARROW = (1.0,)
_SHUTTER_ROUNDS = 4
_FOCAL_ROUNDS = 2
_THREADS = 2
_FRAMES_AHEAD = 8
_NOTHING = PatchViews(point=np.empty(0, dtype=np.int64), uv_px=np.empty((0, 2)), zncc=np.empty(0))


@dataclass(slots=True, kw_only=True, eq=False)
class RefinedMap:
    """Points and what each frame saw of them.

    Attributes:
        selected: which tracks they are and where their patches were cut.
        points_map: (P, 3).
        is_good: (P,) seen by enough keyframes.
        found: the patches found in each frame.
        camera: the camera, with its read-out time where that had to be estimated.
    """

    selected: PatchPoints
    points_map: FloatArray
    is_good: BoolArray
    found: list[PatchViews]
    camera: Camera


def refine(search: "PatchSearch", *, progress: Progress) -> RefinedMap:
    """Find patches in the keyframes, keep those that are found well, find them in all frames.

    Each time the keyframes and points are bundle-adjusted. The structure's poses and the path are
    improved in place.
    """
    camera, skeleton, config = search.camera, search.skeleton, search.config
    structure = skeleton.structure
    search.moving.hide(skeleton)
    candidates = candidate_points(skeleton, camera, config.patch)
    rough = search.run(
        candidates, points_map=structure.points_map[candidates.track],
        frames=skeleton.frames[structure.is_posed], progress=progress,
    )  # fmt: skip
    kept = choose_found(
        [rough.found[f] for f in skeleton.frames], candidates, camera=camera, config=config.patch
    )
    rough = _narrowed(rough, kept)
    if len(kept) < config.min_inliers:
        # Too blurred or too changed for patches: the path by corners is what there is.
        rough.is_good[:] = False
        return rough
    _adjust_all(rough, search, widening=_WIDE_THEN_NARROW)
    fine = search.run(
        rough.selected, points_map=rough.points_map, frames=np.flatnonzero(search.path.is_posed),
        progress=progress,
    )  # fmt: skip
    _finish(fine, search)
    if camera.readout_s is None:
        _calibrate_shutter(fine, search)
    _calibrate_focal(fine, search)
    return fine


def _finish(
    refined: RefinedMap, search: "PatchSearch", *, widening: tuple[float, ...] = _WIDE_THEN_NARROW
) -> None:
    """Adjust the keyframes, then pose all frames by the points."""
    views = _good_views(_adjust_all(refined, search, widening=widening), refined.is_good)
    focal_px = search.skeleton.structure.focal_px
    pose_frames(
        search.path, views, points_map=refined.points_map, focal_px=focal_px, config=search.config
    )


def _calibrate_shutter(refined: RefinedMap, search: "PatchSearch") -> None:
    """Estimate the read-out time and adjust anew, while what is left is significant."""
    cauchy = search.config.final_cauchy_px / search.skeleton.structure.focal_px
    for _ in range(_SHUTTER_ROUNDS):
        views = still_views(refined, search.path, refined.camera)
        estimate = estimate_readout(
            views, [found.uv_px[:, 1] for found in refined.found], path=search.path,
            points_map=refined.points_map, camera=refined.camera, cauchy=cauchy,
        )  # fmt: skip
        if not estimate.is_significant:
            return
        readout_s = (refined.camera.readout_s or 0.0) + estimate.extra_s
        refined.camera = refined.camera.with_readout(readout_s)
        _finish(refined, replace(search, camera=refined.camera), widening=_NARROW)


def _calibrate_focal(refined: RefinedMap, search: "PatchSearch") -> None:
    """Refine the focal length and adjust anew, where the views demand it."""
    structure, frames = search.skeleton.structure, search.skeleton.frames
    for _ in range(_FOCAL_ROUNDS):
        views = still_views(refined, search.path, refined.camera)
        problem = bundle_problem(
            refined, structure, frames=frames, views=views, config=search.config
        )
        in_cam = np.einsum(
            "nij,nj->ni", problem.R_cam_map[problem.camera_index],
            problem.points_map[problem.point_index],
        ) + problem.t_cam_map[problem.camera_index]  # fmt: skip
        off = np.linalg.norm(in_cam[:, :2] / in_cam[:, 2:] - problem.flat, axis=1)
        keep = refined.is_good[problem.point_index] & (off * problem.focal_px < _OUTLIER_PX)
        estimate = estimate_focal(
            replace(
                problem, camera_index=problem.camera_index[keep],
                point_index=problem.point_index[keep], flat=problem.flat[keep],
            )
        )  # fmt: skip
        if not estimate.is_significant:
            return
        refined.camera = with_focal(refined.camera, estimate.factor)
        _finish(refined, replace(search, camera=refined.camera))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PatchSearch:
    """What looking for patches needs; the skeleton's poses and the path move under it."""

    video: GreyVideo
    camera: Camera
    skeleton: Skeleton
    path: FramePath
    moving: MovingFrames
    config: SlamConfig

    def run(
        self, selected: PatchPoints, *, points_map: FloatArray, frames: IntArray, progress: Progress
    ) -> RefinedMap:
        """Look for all patches (P,) in the given frames."""
        structure = self.skeleton.structure
        atlas = PatchAtlas(self.camera, uv_px=selected.uv_px, config=self.config.patch)
        reference = self.skeleton.frames[selected.reference]
        for index, grey in self.video:
            points = np.flatnonzero(reference == index)
            if len(points):
                atlas.take_references(grey, points)
        atlas.place(
            points_map,
            structure.R_cam_map[selected.reference],
            structure.t_cam_map[selected.reference],
        )
        found = [_NOTHING] * len(self.video)
        wanted = set(frames.tolist())
        for done, (index, views) in enumerate(_in_threads(self._jobs(atlas, wanted))):
            found[index] = self.moving.uncovered(index, views)
            progress("aligning patches", done + 1, len(wanted))
        good = np.ones(len(selected.track), dtype=np.bool_)
        return RefinedMap(
            selected=selected, points_map=points_map, is_good=good, found=found, camera=self.camera
        )

    def _jobs(self, atlas: PatchAtlas, wanted: set[int]) -> Iterator["_Job"]:
        twists = self.path.twists()
        for index, grey in self.video:
            if index in wanted:
                yield _Job(
                    index=index, grey=grey, atlas=atlas, R_cam_map=self.path.R_cam_map[index],
                    t_cam_map=self.path.t_cam_map[index], twist=twists[index],
                )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Job:
    """One frame to look for patches in."""

    index: int
    grey: ImageArray
    atlas: PatchAtlas
    R_cam_map: FloatArray
    t_cam_map: FloatArray
    twist: FloatArray

    def run(self) -> tuple[int, PatchViews]:
        found = self.atlas.find(self.grey, self.R_cam_map, self.t_cam_map, twist=self.twist)
        return self.index, found


def _in_threads(jobs: Iterable[_Job]) -> Iterator[tuple[int, PatchViews]]:
    """Run jobs side by side, few at a time, and yield their results in order."""
    with ThreadPoolExecutor(_THREADS) as pool:
        waiting: list[Future[tuple[int, PatchViews]]] = []
        for job in jobs:
            waiting.append(pool.submit(job.run))
            if len(waiting) > _FRAMES_AHEAD:
                yield waiting.pop(0).result()
        for each in waiting:
            yield each.result()


def _narrowed(rough: RefinedMap, kept: IntArray) -> RefinedMap:
    """Return the map with only the kept points (Q,)."""
    rank = np.full(len(rough.points_map), -1, dtype=np.int64)
    rank[kept] = np.arange(len(kept))
    found = []
    for views in rough.found:
        mine = rank[views.point] >= 0
        found.append(
            PatchViews(
                point=rank[views.point[mine]], uv_px=views.uv_px[mine], zncc=views.zncc[mine]
            )
        )
    selected = PatchPoints(
        track=rough.selected.track[kept],
        reference=rough.selected.reference[kept],
        uv_px=rough.selected.uv_px[kept],
    )
    good = np.ones(len(kept), dtype=np.bool_)
    points_map = rough.points_map[kept]
    return RefinedMap(
        selected=selected, points_map=points_map, is_good=good, found=found, camera=rough.camera
    )


def _adjust_all(
    refined: RefinedMap, search: PatchSearch, *, widening: tuple[float, ...]
) -> list[FrameViews]:
    """Adjust keyframes and points, take all frames along; return the views without shutter."""
    structure, path, frames = search.skeleton.structure, search.path, search.skeleton.frames
    views = still_views(refined, path, search.camera)
    problem = bundle_problem(refined, structure, frames=frames, views=views, config=search.config)
    adjust_keyframes(refined, structure, problem, widening=widening)
    posed = structure.is_posed
    path.follow(frames[posed], structure.R_cam_map[posed], structure.t_cam_map[posed])
    return views


def still_views(refined: RefinedMap, path: FramePath, camera: Camera) -> list[FrameViews]:
    """Return the found patches as flat views, as a global shutter would have seen them."""
    twists = path.twists()
    views = []
    for i, found in enumerate(refined.found):
        flat = camera.normalize(found.uv_px)
        if camera.readout_s:
            in_cam = refined.points_map[found.point] @ path.R_cam_map[i].T + path.t_cam_map[i]
            delay_s = camera.row_delay_ns(found.uv_px[:, 1]) / 1e9
            flat = flat - shutter_shift(in_cam, twist=twists[i], delay_s=delay_s)
        views.append(FrameViews(point=found.point, flat=flat))
    return views


def _good_views(views: list[FrameViews], is_good: BoolArray) -> list[FrameViews]:
    kept = []
    for each in views:
        good = is_good[each.point]
        kept.append(FrameViews(point=each.point[good], flat=each.flat[good]))
    return kept


def adjust_keyframes(
    refined: RefinedMap, structure: Structure, whole: BundleProblem, *, widening: tuple[float, ...]
) -> None:
    """Bundle-adjust keyframes and points on their patches, each time without the outliers before.

    The first loss is to be wide where nothing was adjusted yet: where old and new views of a place
    disagree by a pixel, a narrow one would believe whichever are more and throw the others out.

    Args:
        refined: the points.
        structure: the keyframes.
        whole: their views, as `bundle_problem` gives them.
        widening: by how much the loss is wider, for each adjustment.
    """
    keep = np.ones(len(whole.flat), dtype=np.bool_)
    R, t, points = whole.R_cam_map, whole.t_cam_map, whole.points_map
    for wider in widening:
        solved = adjust(
            replace(
                whole, R_cam_map=R, t_cam_map=t, points_map=points,
                camera_index=whole.camera_index[keep], point_index=whole.point_index[keep],
                flat=whole.flat[keep], cauchy_px=wider * whole.cauchy_px,
            )
        )  # fmt: skip
        R, t, points = solved.R_cam_map, solved.t_cam_map, solved.points_map
        in_cam = np.einsum("nij,nj->ni", R[whole.camera_index], points[whole.point_index])
        in_cam += t[whole.camera_index]
        off = np.linalg.norm(in_cam[:, :2] / in_cam[:, 2:] - whole.flat, axis=1)
        keep = off * structure.focal_px < _OUTLIER_PX
    posed, point_index = structure.is_posed, whole.point_index
    structure.R_cam_map[posed], structure.t_cam_map[posed] = R, t
    refined.points_map = points
    refined.is_good = np.bincount(point_index[keep], minlength=len(points)) >= _FEWEST_KEYFRAMES


def bundle_problem(
    refined: RefinedMap,
    structure: Structure,
    *,
    frames: IntArray,
    views: list[FrameViews],
    config: SlamConfig,
) -> BundleProblem:
    """Return the adjustment of all posed keyframes and points on what patches found."""
    posed = np.flatnonzero(structure.is_posed)
    seen = [views[frames[k]] for k in posed]
    return BundleProblem(
        R_cam_map=structure.R_cam_map[posed],
        t_cam_map=structure.t_cam_map[posed],
        points_map=refined.points_map,
        camera_index=np.repeat(np.arange(len(posed)), [len(v.point) for v in seen]),
        point_index=np.concatenate([v.point for v in seen]),
        flat=np.concatenate([v.flat for v in seen]),
        focal_px=structure.focal_px,
        cauchy_px=config.final_cauchy_px,
    )
