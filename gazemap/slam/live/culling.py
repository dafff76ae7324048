"""What the map forgets, so that it stays bounded however long a recording is."""

import numpy as np

from gazemap.geometry.arrays import IntArray
from gazemap.slam.live.mapdata import SparseMap

_LATEST_KEPT = 5
# A point that so many other keyframes measure does not need this one.
_ENOUGH_VIEWS = 4


def cull_keyframes(sparse: SparseMap, *, kept: int) -> None:
    """Empty the most redundant keyframes until at most `kept` hold images and measurements.

    What an emptied keyframe first saw stays in the map: its pose says how those patches lay. It
    goes altogether with the last of them.
    """
    m = sparse.measurements
    live = np.unique(m.keyframe)
    if len(live) > kept:
        m.keep(~np.isin(m.keyframe, _most_redundant(sparse, live, count=len(live) - kept)))
    measured, hosting = set(m.keyframe.tolist()), set(sparse.features.host.tolist())
    latest = max(sparse.keyframes)
    for keyframe_id in list(sparse.keyframes):
        if keyframe_id not in measured:
            sparse.keyframes[keyframe_id].pyramid = None
            sparse.keyframes[keyframe_id].T_cam_world_published = None
            if keyframe_id not in hosting and keyframe_id != latest:
                del sparse.keyframes[keyframe_id]


def _most_redundant(sparse: SparseMap, live: IntArray, *, count: int) -> IntArray:
    m = sparse.measurements
    views = sparse.view_counts()[sparse.features.rows_of(m.feature)]
    slot = np.searchsorted(live, m.keyframe)
    spare = np.bincount(slot, weights=views > _ENOUGH_VIEWS, minlength=len(live))
    share = spare / np.maximum(np.bincount(slot, minlength=len(live)), 1)
    share[-_LATEST_KEPT:] = -1.0
    return live[np.argsort(-share, kind="stable")[:count]]
