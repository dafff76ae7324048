"""Which part of the map is adjusted together, and what is thrown out after."""

import numpy as np

from gazemap.errors import SolverError
from gazemap.geometry.align import Similarity, fit_similarity_of_poses
from gazemap.geometry.arrays import BoolArray, FloatArray, IntArray
from gazemap.geometry.pose import Pose, World
from gazemap.slam.live.bundle import BundleProblem, adjust_bundle
from gazemap.slam.live.mapdata import SparseMap
from gazemap.types.session import TagLayout

_TAG_SIGMA_PX = 0.2
_OUTLIER_SIGMAS = 5.0


def covisible_window(sparse: SparseMap, keyframe_id: int, *, count: int) -> IntArray:
    """Return the ids (at most `count`) that share most points with a keyframe, itself first."""
    m = sparse.measurements
    seen = m.feature[m.keyframe == keyframe_id]
    sharing = m.keyframe[np.isin(m.feature, seen)]
    ids, shared = np.unique(sharing, return_counts=True)
    order = np.argsort(-shared, kind="stable")
    others = [int(i) for i in ids[order] if i != keyframe_id and shared[ids == i][0] >= 10]
    return np.array([keyframe_id, *others[: count - 1]], dtype=np.int64)


def adjust(sparse: SparseMap, free_ids: IntArray, *, layout: TagLayout | None, rounds: int) -> None:
    """Adjust keyframes and the points they see; outlying measurements are dropped after.

    Args:
        sparse: the map.
        free_ids: keyframes that may move; others that see the same points hold them.
        layout: the tags, once the map is in their world; None before.
        rounds: of the solver at most.

    Raises:
        SolverError: if the system is singular; the map is left as it was.
    """
    rows, feature_rows = _chosen_measurements(sparse, free_ids)
    if len(rows) < 12:
        return
    ids = np.unique(sparse.measurements.keyframe[rows])
    free = np.isin(ids, free_ids)
    problem = _problem(sparse, rows, feature_rows, ids=ids, free=free, layout=layout)
    try:
        fit = adjust_bundle(problem, rounds=rounds)
    except np.linalg.LinAlgError as error:
        raise SolverError("bundle adjustment: the keyframes' system is singular") from error
    if not (np.isfinite(fit.points_world).all() and np.isfinite(fit.t).all()):
        raise SolverError("bundle adjustment: diverged")
    for k in np.flatnonzero(free):
        U, _, Vt = np.linalg.svd(fit.R[k])
        sparse.keyframes[int(ids[k])].T_cam_world = Pose(R=U @ Vt, t=fit.t[k])
    sparse.features.points_world[feature_rows] = fit.points_world[: len(feature_rows)]
    if (~free).sum() < 2 and layout is None:
        hold_gauge(sparse)
    keep = np.ones(len(sparse.measurements), bool)
    keep[rows[fit.error[problem.point < len(feature_rows)] > _OUTLIER_SIGMAS]] = False
    sparse.measurements.keep(keep)


def _chosen_measurements(sparse: SparseMap, free_ids: IntArray) -> tuple[IntArray, IntArray]:
    """Return the measurements of all mapped features that the free keyframes see, by feature."""
    m, f = sparse.measurements, sparse.features
    mapped_ids = f.ids[f.mapped]
    in_free = np.isin(m.keyframe, free_ids)
    wanted = np.intersect1d(np.unique(m.feature[in_free]), mapped_ids)
    rows = np.flatnonzero(np.isin(m.feature, wanted))
    rows = rows[np.lexsort((m.keyframe[rows], m.feature[rows]))]
    return rows, f.rows_of(wanted)


def _problem(
    sparse: SparseMap, rows: IntArray, feature_rows: IntArray, *,
    ids: IntArray, free: BoolArray, layout: TagLayout | None,
) -> BundleProblem:  # fmt: skip
    m = sparse.measurements
    camera = sparse.camera
    focal_px = float(camera.K[0, 0])
    keyframes = [sparse.keyframes[int(i)] for i in ids]
    corner_index, corner_rows, corners_world = _tag_rows(sparse, ids, layout)
    point = np.searchsorted(sparse.features.ids[feature_rows], m.feature[rows])
    tag_sigma_px = np.full(len(corner_rows), _TAG_SIGMA_PX)
    return BundleProblem(
        R=np.array([k.T_cam_world.R for k in keyframes]),
        t=np.array([k.T_cam_world.t for k in keyframes]),
        twist=np.array([k.twist for k in keyframes]),
        keyframe_free=free,
        points_world=np.concatenate([sparse.features.points_world[feature_rows], corners_world]),
        point_free=np.arange(len(feature_rows) + len(corners_world)) < len(feature_rows),
        keyframe=np.concatenate([np.searchsorted(ids, m.keyframe[rows]), corner_index[:, 0]]),
        point=np.concatenate([point, len(feature_rows) + corner_index[:, 1]]),
        xy=np.concatenate([m.xy[rows], corner_rows[:, :2]]),
        sigma=np.concatenate([m.sigma_px[rows], tag_sigma_px]) / focal_px,
        dt_s=camera.row_delay_ns(np.concatenate([m.uv_px[rows, 1], corner_rows[:, 2]])) * 1e-9,
    )


def _tag_rows(
    sparse: SparseMap, ids: IntArray, layout: TagLayout | None
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return keyframe and corner (N, 2), x, y, pixel row (N, 3), both by corner; corners (C, 3)."""
    tags = layout.tags if layout is not None else ()
    corners = {tag.tag_id: 4 * n for n, tag in enumerate(tags)}
    index, values = [], []
    for k, keyframe_id in enumerate(ids):
        for view in sparse.keyframes[int(keyframe_id)].tags:
            if view.tag_id in corners:
                index += [(k, corners[view.tag_id] + c) for c in range(4)]
                values += list(np.column_stack([view.corners_norm, view.corners_px[:, 1]]))
    world = [tag.T_world_tag.transform(tag.corners_tag) for tag in tags]
    table = np.array(index, dtype=np.int64).reshape(-1, 2)
    order = np.argsort(table[:, 1], kind="stable")
    return table[order], np.array(values).reshape(-1, 3)[order], np.array(world).reshape(-1, 3)


def hold_gauge(sparse: SparseMap) -> None:
    """Move the map so that its keyframes lie where their poses were published.

    Origin, heading and scale are free without tags; users have seen the published ones.
    """
    pairs = [
        (k.T_cam_world.inverse(), k.T_cam_world_published.inverse())
        for k in sparse.keyframes.values()
        if k.T_cam_world_published is not None
    ]
    S: Similarity[World, World] | None = fit_similarity_of_poses(
        [now for now, _ in pairs], [told for _, told in pairs]
    )
    if S is not None and 0.2 < S.scale < 5.0:
        sparse.move(S)
