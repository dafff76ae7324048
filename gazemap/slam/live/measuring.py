"""Measuring points of the map in keyframes: their patches are predicted and aligned."""

import numpy as np

from gazemap.geometry.arrays import IntArray
from gazemap.slam.live.config import FrontEndConfig
from gazemap.slam.live.landmarks import see
from gazemap.slam.live.mapdata import Keyframe, SparseMap
from gazemap.slam.live.patches import align_patches


def measure_rows(
    sparse: SparseMap, keyframe: Keyframe, rows: IntArray, *, config: FrontEndConfig
) -> None:
    """Measure features (rows of the table) in a keyframe, where it shows them."""
    if len(rows) == 0 or keyframe.pyramid is None:
        return
    f = sparse.features
    steps, facing = sparse.surface_steps(rows)
    view = see(sparse.camera, keyframe.T_cam_world, f.points_world[rows], steps, facing)
    uv_px, correlation = align_patches(
        keyframe.pyramid, f.references[rows[view.rows]], view.from_image, view.uv_px, coarse=True
    )
    good = correlation > config.least_correlation
    sparse.measure(
        keyframe.keyframe_id,
        f.ids[rows[view.rows[good]]],
        uv_px[good],
        sigma_px=np.full(int(good.sum()), config.patch_sigma_px),
    )


def measure_everything(sparse: SparseMap, keyframe: Keyframe, *, config: FrontEndConfig) -> None:
    """Measure the points that tracking did not choose but the keyframe sees."""
    f, m = sparse.features, sparse.measurements
    seen = m.feature[m.keyframe == keyframe.keyframe_id]
    rows = np.flatnonzero(f.mapped & ~np.isin(f.ids, seen))
    measure_rows(sparse, keyframe, rows, config=config)


def measure_elsewhere(
    sparse: SparseMap, ids: IntArray, keyframe_ids: IntArray, *, config: FrontEndConfig
) -> None:
    """Measure new points in keyframes that saw them before they were points."""
    for other_id in keyframe_ids:
        m = sparse.measurements
        missing = ids[~np.isin(ids, m.feature[m.keyframe == other_id])]
        rows = sparse.features.rows_of(missing)
        measure_rows(sparse, sparse.keyframes[int(other_id)], rows, config=config)


def measure_anew(sparse: SparseMap, ids: IntArray, *, config: FrontEndConfig) -> None:
    """Measure points in all keyframes again, now that their geometry predicts their patches."""
    f, m = sparse.features, sparse.measurements
    ids = ids[f.has(ids)]
    hosts = f.host[f.rows_of(m.feature)]
    m.keep(~np.isin(m.feature, ids) | (m.keyframe == hosts))
    rows = f.rows_of(ids)
    for keyframe in sparse.keyframes.values():
        elsewhere = rows[f.host[rows] != keyframe.keyframe_id]
        measure_rows(sparse, keyframe, elsewhere, config=config)
