"""The scale of a map from registered depth images: what is measured over what the map has."""

from collections.abc import Iterable, Sequence

import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray
from gazemap.slam.frame_path import FramePath
from gazemap.slam.patches import PatchViews
from gazemap.types.frame import DepthFrame

# Neighbouring images show the same points again.
_PERIOD_NS = 250_000_000
_LARGEST_SHIFT_NS = 20_000_000
# Next to an edge the pixel may show what is behind.
_LARGEST_STEP = 0.03
_FEWEST_POINTS = 100
_WIDEST_SPREAD = 0.15


def scale_from_depth(
    depth_frames: Iterable[DepthFrame],
    *,
    path: FramePath,
    found: Sequence[PatchViews],
    points_map: FloatArray,
    is_good: BoolArray,
) -> float | None:
    """Return metres per unit of the map; None where depth is missing or contradicts the map.

    Args:
        depth_frames: registered to the head camera, in time order.
        path: the poses of all frames.
        found: the patches found in each frame.
        points_map: (P, 3).
        is_good: (P,) points that count.
    """
    ratios: list[FloatArray] = [np.empty(0)]
    last_ns = -_PERIOD_NS
    for depth in depth_frames:
        if depth.t_ns - last_ns < _PERIOD_NS:
            continue
        i = int(np.abs(path.t_ns - depth.t_ns).argmin())
        if not path.is_posed[i] or abs(int(path.t_ns[i]) - depth.t_ns) > _LARGEST_SHIFT_NS:
            continue
        last_ns = depth.t_ns
        seen = is_good[found[i].point]
        points = points_map[found[i].point[seen]]
        depth_map = points @ path.R_cam_map[i, 2] + path.t_cam_map[i, 2]
        measured_m = _smooth_depth(depth, found[i].uv_px[seen])
        ratios.append((measured_m / depth_map)[np.isfinite(measured_m)])
    ratio = np.concatenate(ratios)
    if len(ratio) < _FEWEST_POINTS:
        return None
    low, middle, high = np.quantile(ratio, [0.25, 0.5, 0.75])
    return float(middle) if high - low < _WIDEST_SPREAD * middle else None


def _smooth_depth(depth: DepthFrame, uv_px: FloatArray) -> FloatArray:
    """Return the depth in metres at pixels (N, 2); NaN at edges and where it was not measured."""
    height, width = depth.depth_m.shape
    at = np.rint(uv_px).astype(np.int64)
    inside = (at > 0).all(axis=1) & (at[:, 0] < width - 1) & (at[:, 1] < height - 1)
    out = np.full(len(uv_px), np.nan)
    offset = np.array([-1, 0, 1])
    rows, columns = at[inside, 1, None, None], at[inside, 0, None, None]
    window = depth.depth_m[rows + offset[:, None], columns + offset].reshape(-1, 9)
    step = window.max(axis=1) - window.min(axis=1)  # NaN where any is
    middle = window[:, 4].astype(np.float64)
    out[inside] = np.where(step < _LARGEST_STEP * middle, middle, np.nan)
    return out
