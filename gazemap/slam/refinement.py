"""The decisive step: points found again by fixed patches in every frame, and a final adjustment."""

from dataclasses import dataclass

import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.ports import Progress
from gazemap.slam.bundle import BundleProblem, adjust
from gazemap.slam.config import PatchConfig, SlamConfig
from gazemap.slam.frame_path import FramePath, shutter_shift
from gazemap.slam.framewise import FrameViews, pose_frames
from gazemap.slam.front import Skeleton
from gazemap.slam.patches import PatchAtlas, PatchViews
from gazemap.slam.structure import Structure
from gazemap.slam.video import GreyVideo

_OUTLIER_PX = 2.0
_FEWEST_KEYFRAMES = 3
_SHUTTER_ROUNDS = 2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PatchPoints:
    """The points that get patches.

    Attributes:
        track: (P,) their tracks in the structure.
        reference: (P,) keyframe each patch is cut from.
        uv_px: (P, 2) its centre there.
    """

    track: IntArray
    reference: IntArray
    uv_px: FloatArray


@dataclass(slots=True, kw_only=True, eq=False)
class RefinedMap:
    """Points and what each frame saw of them.

    Attributes:
        selected: which tracks they are and where their patches were cut.
        points_map: (P, 3).
        is_good: (P,) seen by enough keyframes.
        found: the patches found in each frame.
        shift: flat shift of each found patch by the rolling shutter.
    """

    selected: PatchPoints
    points_map: FloatArray
    is_good: BoolArray
    found: list[PatchViews]
    shift: list[FloatArray]


def choose_points(skeleton: Skeleton, config: PatchConfig) -> PatchPoints:
    """Return the longest-seen points so that each keyframe has as many in view as are wanted."""
    structure = skeleton.structure
    rows = np.flatnonzero(
        structure.is_valid & structure.has_point[structure.track]
        & structure.is_posed[structure.keyframe]
    )  # fmt: skip
    rows = rows[np.argsort(structure.track[rows], kind="stable")]
    start = np.searchsorted(structure.track[rows], np.arange(len(structure.has_point) + 1))
    length = np.diff(start)
    wanted = np.full(len(structure.is_posed), config.points_per_keyframe)
    chosen, reference_row = [], []
    for j in np.argsort(-length, kind="stable").tolist():
        if length[j] < _FEWEST_KEYFRAMES:
            break
        mine = rows[start[j] : start[j + 1]]
        seen_by = structure.keyframe[mine]
        if (wanted[seen_by] > 0).mean() >= 0.5:
            wanted[seen_by] -= 1
            chosen.append(j)
            reference_row.append(mine[len(mine) // 2])
    at = np.array(reference_row, dtype=np.int64)
    return PatchPoints(
        track=np.array(chosen, dtype=np.int64),
        reference=structure.keyframe[at],
        uv_px=skeleton.uv_px[at],
    )


def refine(
    video: GreyVideo,
    camera: Camera,
    *,
    skeleton: Skeleton,
    path: FramePath,
    config: SlamConfig,
    progress: Progress,
) -> RefinedMap:
    """Find the patches in all frames, adjust the keyframes, and pose every frame anew.

    The structure's poses and the path are improved in place.
    """
    structure = skeleton.structure
    selected = choose_points(skeleton, config.patch)
    atlas = PatchAtlas(camera, uv_px=selected.uv_px, config=config.patch)
    _cut_references(atlas, video, selected=selected, frames=skeleton.frames)
    refined = RefinedMap(
        selected=selected,
        points_map=structure.points_map[selected.track],
        is_good=np.ones(len(selected.track), dtype=np.bool_),
        found=[],
        shift=[],
    )
    R_ref, t_ref = structure.R_cam_map[selected.reference], structure.t_cam_map[selected.reference]
    atlas.place(refined.points_map, R_ref, t_ref)
    _find_patches(refined, atlas, video=video, path=path, progress=progress)
    views = _flat_views(refined, camera)
    for _ in range(_SHUTTER_ROUNDS if camera.readout_s else 1):
        if camera.readout_s:
            refined.shift = shutter_shifts(refined, path, camera)
        still = _without_shift(views, refined)
        adjust_keyframes(refined, structure, frames=skeleton.frames, views=still, config=config)
        good = _good_views(still, refined.is_good)
        pose_frames(
            path, good, points_map=refined.points_map, focal_px=structure.focal_px, config=config
        )
    return refined


def _cut_references(
    atlas: PatchAtlas, video: GreyVideo, *, selected: PatchPoints, frames: IntArray
) -> None:
    points_of = {int(frames[k]): selected.reference == k for k in np.unique(selected.reference)}
    for index, grey in video:
        if index in points_of:
            atlas.take_references(grey, np.flatnonzero(points_of[index]))


def _find_patches(
    refined: RefinedMap, atlas: PatchAtlas, *, video: GreyVideo, path: FramePath, progress: Progress
) -> None:
    nothing = PatchViews(
        point=np.empty(0, dtype=np.int64), uv_px=np.empty((0, 2)), zncc=np.empty(0)
    )
    for index, grey in video:
        found = nothing
        if path.is_posed[index]:
            found = atlas.find(grey, path.R_cam_map[index], path.t_cam_map[index])
        refined.found.append(found)
        refined.shift.append(np.zeros((len(found.point), 2)))
        progress("aligning patches", index + 1, len(video))


def _flat_views(refined: RefinedMap, camera: Camera) -> list[FrameViews]:
    return [
        FrameViews(point=each.point, flat=camera.normalize(each.uv_px)) for each in refined.found
    ]


def _without_shift(views: list[FrameViews], refined: RefinedMap) -> list[FrameViews]:
    return [
        FrameViews(point=each.point, flat=each.flat - shift)
        for each, shift in zip(views, refined.shift, strict=True)
    ]


def _good_views(views: list[FrameViews], is_good: BoolArray) -> list[FrameViews]:
    kept = []
    for each in views:
        good = is_good[each.point]
        kept.append(FrameViews(point=each.point[good], flat=each.flat[good]))
    return kept


def shutter_shifts(refined: RefinedMap, path: FramePath, camera: Camera) -> list[FloatArray]:
    """Return how far the rolling shutter moved each found patch, in flat units."""
    twists = path.twists()
    shifts = []
    for i, found in enumerate(refined.found):
        in_cam = refined.points_map[found.point] @ path.R_cam_map[i].T + path.t_cam_map[i]
        delay_s = camera.row_delay_ns(found.uv_px[:, 1]) / 1e9
        shifts.append(shutter_shift(in_cam, twist=twists[i], delay_s=delay_s))
    return shifts


def adjust_keyframes(
    refined: RefinedMap,
    structure: Structure,
    *,
    frames: IntArray,
    views: list[FrameViews],
    config: SlamConfig,
) -> None:
    """Bundle-adjust keyframes and points on their patches, twice: the second without outliers."""
    posed = np.flatnonzero(structure.is_posed)
    seen = [views[frames[k]] for k in posed]
    camera_index = np.repeat(np.arange(len(posed)), [len(v.point) for v in seen])
    point_index = np.concatenate([v.point for v in seen])
    flat = np.concatenate([v.flat for v in seen])
    keep = np.ones(len(flat), dtype=np.bool_)
    R, t, points = structure.R_cam_map[posed], structure.t_cam_map[posed], refined.points_map
    for _ in range(2):
        solved = adjust(
            BundleProblem(
                R_cam_map=R, t_cam_map=t, points_map=points, camera_index=camera_index[keep],
                point_index=point_index[keep], flat=flat[keep], focal_px=structure.focal_px,
                cauchy_px=config.final_cauchy_px,
            )
        )  # fmt: skip
        R, t, points = solved.R_cam_map, solved.t_cam_map, solved.points_map
        in_cam = np.einsum("nij,nj->ni", R[camera_index], points[point_index]) + t[camera_index]
        off = np.linalg.norm(in_cam[:, :2] / in_cam[:, 2:] - flat, axis=1) * structure.focal_px
        keep = off < _OUTLIER_PX
    structure.R_cam_map[posed], structure.t_cam_map[posed] = R, t
    refined.points_map = points
    refined.is_good = np.bincount(point_index[keep], minlength=len(points)) >= _FEWEST_KEYFRAMES
