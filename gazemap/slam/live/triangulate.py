"""New points from corners that several keyframes saw."""

from dataclasses import dataclass

import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, IntArray
from gazemap.slam.live.config import MappingConfig
from gazemap.slam.live.mapdata import SparseMap


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Rays:
    """Measurements of unmapped features, sorted by feature.

    Attributes:
        feature: (N,) index into `ids`.
        ids: (F,) the features.
        origin: (N, 3) camera centres in world.
        direction: (N, 3) unit rays in world.
        R_cam_world: (N, 3, 3) of `T_cam_world`.
        xy: (N, 2) as measured.
    """

    feature: IntArray
    ids: IntArray
    origin: FloatArray
    direction: FloatArray
    R_cam_world: FloatArray
    xy: FloatArray


def triangulate_new(sparse: SparseMap, config: MappingConfig, *, least_views: int) -> IntArray:
    """Give a position to features with enough parallax; return their ids."""
    rays = _unmapped_rays(sparse, least_views)
    if len(rays.ids) == 0:
        return np.empty(0, np.int64)
    points, parallax_rad = _intersect(rays)
    worst = _worst_error(rays, points) * float(sparse.camera.K[0, 0])
    good = (parallax_rad > np.radians(config.least_parallax_deg)) & (worst < config.worst_error_px)
    ids: IntArray = rays.ids[good]
    sparse.features.points_world[sparse.features.rows_of(ids)] = points[good]
    return ids


def _unmapped_rays(sparse: SparseMap, least_views: int) -> _Rays:
    m, f = sparse.measurements, sparse.features
    ids, counts = np.unique(m.feature[np.isin(m.feature, f.ids[~f.mapped])], return_counts=True)
    ids = ids[counts >= least_views]
    rows = np.flatnonzero(np.isin(m.feature, ids))
    rows = rows[np.lexsort((m.keyframe[rows], m.feature[rows]))]
    keyframe_ids, which = np.unique(m.keyframe[rows], return_inverse=True)
    poses = [sparse.keyframes[int(k)].T_cam_world for k in keyframe_ids]
    R = np.array([T.R for T in poses]).reshape(-1, 3, 3)[which]
    origin = np.array([T.inverse().t for T in poses]).reshape(-1, 3)[which]
    ray = np.column_stack([m.xy[rows], np.ones(len(rows))])
    ray /= np.linalg.norm(ray, axis=1, keepdims=True)
    return _Rays(
        feature=np.searchsorted(ids, m.feature[rows]),
        ids=ids,
        origin=origin,
        direction=np.einsum("nji,nj->ni", R, ray),
        R_cam_world=R,
        xy=m.xy[rows],
    )


def _intersect(rays: _Rays) -> tuple[FloatArray, FloatArray]:
    """Return the point (F, 3) nearest to each feature's rays, and its largest parallax (F,)."""
    count = len(rays.ids)
    across = np.eye(3) - rays.direction[:, :, None] * rays.direction[:, None, :]  # (N, 3, 3)
    normal, b = np.zeros((count, 3, 3)), np.zeros((count, 3))
    np.add.at(normal, rays.feature, across)
    np.add.at(b, rays.feature, np.einsum("nij,nj->ni", across, rays.origin))
    points = np.asarray(np.linalg.solve(normal + 1e-12 * np.eye(3), b[:, :, None]))[:, :, 0]
    first = np.searchsorted(rays.feature, np.arange(count))
    cosine = (rays.direction * rays.direction[first][rays.feature]).sum(axis=1)
    widest = np.ones(count)
    np.minimum.at(widest, rays.feature, cosine)
    return points.astype(np.float64), np.arccos(np.clip(widest, -1.0, 1.0))


def _worst_error(rays: _Rays, points: FloatArray) -> FloatArray:
    """Return each feature's largest reprojection error (F,) in x/z, y/z; infinite behind."""
    away = points[rays.feature] - rays.origin
    in_cam = np.einsum("nij,nj->ni", rays.R_cam_world, away)
    in_front: BoolArray = in_cam[:, 2] > 1e-6
    depth = np.where(in_front, in_cam[:, 2], 1.0)
    error = np.linalg.norm(in_cam[:, :2] / depth[:, None] - rays.xy, axis=1)
    worst = np.zeros(len(rays.ids))
    np.maximum.at(worst, rays.feature, np.where(in_front, error, np.inf))
    return worst
