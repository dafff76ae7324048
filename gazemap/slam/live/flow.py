"""Optical flow from frame to frame: fast and far-reaching, but it drifts."""

import cv2
import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray
from gazemap.slam.live.config import FrontEndConfig

_CRITERIA = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 15, 0.03)


def follow(
    before: ImageArray,
    after: ImageArray,
    uv_px: FloatArray,
    guess_px: FloatArray,
    config: FrontEndConfig,
) -> tuple[FloatArray, BoolArray]:
    """Return where pixels (N, 2) of one image are in the next, and which were found (N,)."""
    if len(uv_px) == 0:
        return np.empty((0, 2)), np.empty(0, bool)
    side = config.flow_window_px
    moved, status, _ = cv2.calcOpticalFlowPyrLK(
        before, after, uv_px.astype(np.float32), guess_px.astype(np.float32),
        winSize=(side, side), maxLevel=config.flow_levels, criteria=_CRITERIA,
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW, minEigThreshold=1e-4,
    )  # fmt: skip
    found = np.asarray(status).ravel() > 0
    out = np.asarray(moved, dtype=np.float64).reshape(-1, 2)
    height, width = after.shape[:2]
    found &= (out > 8).all(axis=1) & (out[:, 0] < width - 9) & (out[:, 1] < height - 9)
    return out, found


def follow_both_ways(
    before: ImageArray, after: ImageArray, uv_px: FloatArray, config: FrontEndConfig
) -> tuple[FloatArray, BoolArray]:
    """As `follow`, with the way back as a check."""
    moved, found = follow(before, after, uv_px, uv_px, config)
    back, returned = follow(after, before, moved, uv_px, config)
    same = np.linalg.norm(back - uv_px, axis=1) < 0.5
    return moved, found & returned & same
