"""A recorded session turned into a path and a sparse map, as accurately as it gives."""

from dataclasses import dataclass

import numpy as np

from gazemap.geometry.align import Similarity
from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.ports import Progress, Session
from gazemap.slam.bootstrap import bootstrap
from gazemap.slam.config import SlamConfig
from gazemap.slam.frame_path import FramePath
from gazemap.slam.framewise import pose_frames_by_corners
from gazemap.slam.front import FollowedCorners, Skeleton, build_skeleton, follow_corners
from gazemap.slam.growth import grow
from gazemap.slam.join import join
from gazemap.slam.loops import close_all_loops
from gazemap.slam.moving_frames import find_moving
from gazemap.slam.placement import Placement, PosedMap, place
from gazemap.slam.refinement import PatchSearch, RefinedMap, refine
from gazemap.slam.tag_alignment import Map
from gazemap.slam.video import GreyVideo
from gazemap.types.slam import SlamResult, SparseMap
from gazemap.types.tracking import Lost, LostReason, Scale, Tracked, TrackingOutcome, Trajectory

# What the first round has bent is near enough for the second to recognise more.
_LOOP_ROUNDS = 2


def _silent(stage: str, done: int, total: int) -> None:
    """Take a report and do nothing."""


def map_session(
    session: Session,
    config: SlamConfig,
    *,
    progress: Progress | None = None,
    use_tags: bool = True,
) -> SlamResult:
    """Track and map a recording; the same input gives the same result to the bit.

    Args:
        session: the recording; its scene video is decoded once, or twice where it is long.
        config: the settings.
        progress: told how far it has come.
        use_tags: whether the session's tags set the world; without them the scale is arbitrary.
    """
    report = progress or _silent
    camera = session.scene_camera
    t_ns = np.array(session.scene_t_ns, dtype=np.int64)
    video = GreyVideo(session, memory_bytes=config.memory_bytes)
    followed = follow_corners(video, camera, config=config, progress=report)
    skeleton = build_skeleton(followed, camera, config=config)
    if not bootstrap(skeleton.structure, config):
        return _nothing(t_ns.tolist(), camera, followed)
    report("growing the map", 0, 0)
    _grow_whole(skeleton, video, config)
    path = pose_frames_by_corners(followed, skeleton, t_ns=t_ns, config=config)
    moving = find_moving(followed, camera, skeleton=skeleton, path=path)
    search = PatchSearch(
        video=video, camera=camera, skeleton=skeleton, path=path, moving=moving, config=config
    )
    refined = refine(search, progress=report)
    camera = refined.camera
    warnings = []
    if camera.readout_s is not None and session.scene_camera.readout_s is None:
        warnings.append(f"read-out time unknown: estimated as {camera.readout_s * 1e3:.1f} ms")
    posed = PosedMap(video=video, camera=camera, path=path, frames=skeleton.frames, refined=refined)
    placement = place(session, posed, config=config, use_tags=use_tags)
    estimate = _Estimate(
        camera=camera, followed=followed, skeleton=skeleton, path=path, refined=refined,
        placement=placement,
    )  # fmt: skip
    return _result(estimate, (*warnings, *placement.warnings))


def _grow_whole(skeleton: Skeleton, video: GreyVideo, config: SlamConfig) -> None:
    """Grow the map as far as corners reach, join what they do not connect, close loops."""
    grow(skeleton.structure, config)
    while join(skeleton, video, config=config):
        grow(skeleton.structure, config)
    for _ in range(_LOOP_ROUNDS):
        if not close_all_loops(skeleton, video):
            break
        grow(skeleton.structure, config)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Estimate:
    camera: Camera
    followed: FollowedCorners
    skeleton: Skeleton
    path: FramePath
    refined: RefinedMap
    placement: Placement

    @property
    def S_world_map(self) -> Similarity[World, Map]:
        return self.placement.S_world_map


def _result(estimate: _Estimate, warnings: tuple[str, ...]) -> SlamResult:
    outcomes = _outcomes(estimate)
    tracked = [each for each in outcomes if isinstance(each, Tracked)]
    return SlamResult(
        trajectory=Trajectory.from_outcomes(tracked, scale=estimate.placement.scale),
        outcomes=outcomes,
        map=_sparse_map(estimate),
        camera=estimate.camera,
        warnings=warnings,
        surveyed_tags=estimate.placement.surveyed_tags,
    )


def _outcomes(estimate: _Estimate) -> tuple[TrackingOutcome, ...]:
    path, is_blank = estimate.path, estimate.followed.is_blank
    outcomes: list[TrackingOutcome] = []
    for i, t_ns in enumerate(path.t_ns.tolist()):
        if not path.is_posed[i]:
            reason = LostReason.BLANK if is_blank[i] else LostReason.FEW_INLIERS
            outcomes.append(Lost(t_ns=t_ns, reason=reason))
            continue
        outcomes.append(
            Tracked(
                t_ns=t_ns,
                T_world_cam=estimate.S_world_map.transform_pose(_pose_in_map(path, i)),
                cov_cam=_covariance(path, i, estimate=estimate),
                is_relocalised=i > 0 and not path.is_posed[i - 1] and bool(path.is_posed[:i].any()),
            )
        )
    return tuple(outcomes)


def _pose_in_map(path: FramePath, i: int) -> Pose[Map, Cam]:
    T_cam_map: Pose[Cam, Map] = Pose(R=path.R_cam_map[i], t=path.t_cam_map[i])
    return T_cam_map.inverse()


def _covariance(path: FramePath, i: int, *, estimate: _Estimate) -> FloatArray | None:
    """Return the covariance (6, 6) of the right tangent of `T_world_cam`."""
    sigma = estimate_sigma(estimate)
    try:
        left = np.linalg.inv(path.information[i]) * sigma**2
    except np.linalg.LinAlgError:
        return None
    # A left tangent of T_cam_map is, up to its sign, a right one of T_map_cam.
    scale = np.repeat([1.0, estimate.S_world_map.scale], 3)
    return np.asarray(left * np.outer(scale, scale))


def estimate_sigma(estimate: _Estimate) -> float:
    """Return the standard deviation of one coordinate of a patch's view, in flat units."""
    return 0.25 / estimate.skeleton.structure.focal_px


def _sparse_map(estimate: _Estimate) -> SparseMap:
    refined, skeleton = estimate.refined, estimate.skeleton
    good = np.flatnonzero(refined.is_good)
    rank = np.full(len(refined.is_good), -1, dtype=np.int64)
    rank[good] = np.arange(len(good))
    posed = [int(f) for f in skeleton.frames if estimate.path.is_posed[f]]
    found = [refined.found[f] for f in posed]
    keyframe = np.repeat(np.arange(len(posed)), [len(v.point) for v in found])
    point = rank[np.concatenate([v.point for v in found])]
    uv_px = np.concatenate([v.uv_px for v in found])
    colour_of = np.zeros((len(skeleton.structure.has_point), 3), dtype=np.uint8)
    kept = skeleton.track_of >= 0
    colour_of[skeleton.track_of[kept]] = estimate.followed.colours[kept]
    keep = point >= 0
    return SparseMap(
        points_world=estimate.S_world_map.transform(refined.points_map[good]),
        colours=colour_of[refined.selected.track[good]],
        cov_world=_point_covariance(estimate, good),
        keyframe_t_ns=estimate.path.t_ns[posed],
        view_keyframe=keyframe[keep],
        view_point=point[keep],
        view_uv_px=uv_px[keep],
    )


def _point_covariance(estimate: _Estimate, good: np.ndarray) -> FloatArray:
    """Return the covariances (G, 3, 3) of points given the poses of the keyframes."""
    refined, path = estimate.refined, estimate.path
    information = np.zeros((len(refined.is_good), 3, 3))
    for f in estimate.skeleton.frames.tolist():
        point = refined.found[f].point
        R = path.R_cam_map[f]
        in_cam = refined.points_map[point] @ R.T + path.t_cam_map[f]
        z = in_cam[:, 2]
        J = np.zeros((len(point), 2, 3))
        J[:, 0, 0] = J[:, 1, 1] = 1 / z
        J[:, :, 2] = -in_cam[:, :2] / z[:, None] ** 2
        J = J @ R
        np.add.at(information, point, J.transpose(0, 2, 1) @ J)
    spread = np.linalg.inv(information[good]) * estimate_sigma(estimate) ** 2
    turned = estimate.S_world_map.R @ spread @ estimate.S_world_map.R.T
    scaled: FloatArray = turned * estimate.S_world_map.scale**2
    return scaled


def _nothing(t_ns: list[int], camera: Camera, followed: FollowedCorners) -> SlamResult:
    """Return the result of a recording that shows no parallax or too little texture."""
    reason = [LostReason.BLANK if blank else LostReason.STARTING for blank in followed.is_blank]
    empty = SparseMap(
        points_world=np.empty((0, 3)),
        colours=np.empty((0, 3), dtype=np.uint8),
        cov_world=np.empty((0, 3, 3)),
        keyframe_t_ns=np.empty(0, dtype=np.int64),
        view_keyframe=np.empty(0, dtype=np.int64),
        view_point=np.empty(0, dtype=np.int64),
        view_uv_px=np.empty((0, 2)),
    )
    return SlamResult(
        trajectory=Trajectory.from_outcomes([], scale=Scale.ARBITRARY),
        outcomes=tuple(Lost(t_ns=t, reason=r) for t, r in zip(t_ns, reason, strict=True)),
        map=empty,
        camera=camera,
        warnings=("no map: the camera hardly moved, or too little texture is in view",),
    )
