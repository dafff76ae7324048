"""Which frames the map is built from."""

from collections.abc import Sequence

import numpy as np

from gazemap.geometry.arrays import IntArray
from gazemap.slam.config import SlamConfig
from gazemap.slam.klt import Corners

_HARDLY_ANY = 0.2


def choose_keyframes(corners: Sequence[Corners], config: SlamConfig) -> IntArray:
    """Return the frames (K,) after which corners moved far, got lost, or time went by."""
    chosen: list[int] = []
    for i, here in enumerate(corners):
        if len(here) >= config.min_inliers and (
            not chosen or _is_due(corners[chosen[-1]], here, gap=i - chosen[-1], config=config)
        ):
            chosen.append(i)
    return np.array(chosen, dtype=np.int64)


def _is_due(last: Corners, here: Corners, *, gap: int, config: SlamConfig) -> bool:
    if gap >= config.keyframe_gap:
        return True
    _, i, j = np.intersect1d(last.track_id, here.track_id, assume_unique=True, return_indices=True)
    survivors = len(i) / max(len(last), 1)
    if survivors < _HARDLY_ANY:
        return True
    if gap < config.keyframe_rest:
        return False
    shift_px = np.linalg.norm(last.uv_px[i] - here.uv_px[j], axis=1)
    return bool(
        survivors < config.keyframe_survivors or np.median(shift_px) > config.keyframe_shift_px
    )
