"""Corners that are followed from frame to frame."""

from dataclasses import dataclass

import cv2
import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray, IntArray
from gazemap.slam.config import KltConfig


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Corners:
    """The corners of one frame.

    Attributes:
        track_id: (N,) the same number for the same corner in every frame, ascending.
        uv_px: (N, 2) on the distorted image.
    """

    track_id: IntArray
    uv_px: FloatArray

    def __len__(self) -> int:
        return len(self.track_id)


NO_CORNERS = Corners(track_id=np.empty(0, dtype=np.int64), uv_px=np.empty((0, 2)))


class CornerTracker:
    """Follows corners by pyramidal Lucas-Kanade; holds the last frame and its corners."""

    def __init__(self, config: KltConfig) -> None:
        """Start without a frame."""
        self._config = config
        self._last: ImageArray | None = None
        self._corners = NO_CORNERS
        self._velocity_px = np.empty((0, 2))
        self._next_id = 0
        self._frames_to_top_up = 0

    def track(self, grey: ImageArray) -> Corners:
        """Return the corners of the next frame (height, width); none for a blank one."""
        if self.is_blank(grey):
            self._corners, self._last = NO_CORNERS, None
            self._velocity_px = np.empty((0, 2))
            self._frames_to_top_up = 0
            return NO_CORNERS
        if self._last is not None and len(self._corners):
            self._follow(self._last, grey)
        self._last = grey
        self._top_up(grey)
        return self._corners

    def is_blank(self, grey: ImageArray) -> bool:
        """Return whether the frame shows nothing: a cap, a black-out or a white-out."""
        return float(grey[::8, ::8].std()) < self._config.blank_grey

    def _follow(self, last: ImageArray, grey: ImageArray) -> None:
        start = self._corners.uv_px.astype(np.float32)
        guess = start + self._velocity_px.astype(np.float32)
        end, found = self._flow(last, grey, start=start, guess=guess)
        back, found_back = self._flow(grey, last, start=end, guess=start)
        closes = np.linalg.norm(back - start, axis=1) < self._config.forward_backward_px
        keep = found & found_back & closes & _inside(end, grey, margin_px=4)
        self._corners = Corners(track_id=self._corners.track_id, uv_px=end.astype(np.float64))
        self._velocity_px = (end - start).astype(np.float64)
        self._keep(keep)

    def _keep(self, chosen: BoolArray | IntArray) -> None:
        self._corners = Corners(
            track_id=self._corners.track_id[chosen], uv_px=self._corners.uv_px[chosen]
        )
        self._velocity_px = self._velocity_px[chosen]

    def _flow(
        self, a: ImageArray, b: ImageArray, *, start: np.ndarray, guess: np.ndarray
    ) -> tuple[np.ndarray, BoolArray]:
        side = self._config.window_px
        end, status, _ = cv2.calcOpticalFlowPyrLK(
            a, b, start, guess.copy(), winSize=(side, side), maxLevel=self._config.levels,
            criteria=(cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 20, 0.02),
            flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
        )  # fmt: skip
        return end, status.ravel() == 1

    def _top_up(self, grey: ImageArray) -> None:
        if self._frames_to_top_up > 0:
            self._frames_to_top_up -= 1
            return
        self._frames_to_top_up = self._config.top_up_every - 1
        self._keep(oldest_in_cell(grey.shape, self._corners.uv_px, config=self._config))
        new_px = best_corners(grey, taken_px=self._corners.uv_px, config=self._config)
        new_id = np.arange(self._next_id, self._next_id + len(new_px), dtype=np.int64)
        self._next_id += len(new_px)
        self._corners = Corners(
            track_id=np.concatenate([self._corners.track_id, new_id]),
            uv_px=np.concatenate([self._corners.uv_px, new_px]),
        )
        still = np.zeros((len(new_px), 2))
        # A new corner starts with the flow of its neighbours.
        if len(self._velocity_px):
            still += np.median(self._velocity_px, axis=0)
        self._velocity_px = np.concatenate([self._velocity_px, still])


def oldest_in_cell(shape: tuple[int, ...], uv_px: FloatArray, *, config: KltConfig) -> IntArray:
    """Return which of the corners (N, 2), oldest first, are the only one kept of their cell."""
    # Half the side of the cells that are filled: a corner that drifts next to another may stay.
    cell = _cell_px(shape, config) // 2
    column, row = (uv_px // cell).astype(np.int64).T
    return np.sort(np.unique(row * (shape[1] // cell + 1) + column, return_index=True)[1])


def _cell_px(shape: tuple[int, ...], config: KltConfig) -> int:
    return int(max(8, round((shape[0] * shape[1] / config.cell_count) ** 0.5)))


def best_corners(grey: ImageArray, *, taken_px: FloatArray, config: KltConfig) -> FloatArray:
    """Return the best corner (N, 2) of each cell that holds none yet."""
    height, width = grey.shape
    cell = _cell_px(grey.shape, config)
    rows, columns = height // cell, width // cell
    strength = cv2.cornerMinEigenVal(grey, 5, ksize=3) * 255.0**2
    margin = config.window_px // 2 + 2
    strength[:margin], strength[-margin:] = 0, 0
    strength[:, :margin], strength[:, -margin:] = 0, 0
    grid = strength[: rows * cell, : columns * cell].reshape(rows, cell, columns, cell)
    cells = grid.transpose(0, 2, 1, 3).reshape(rows * columns, cell * cell)
    best = cells.argmax(axis=1)
    quality = cells[np.arange(len(cells)), best]
    index = np.arange(rows * columns)
    v = index // columns * cell + best // cell
    u = index % columns * cell + best % cell
    free = np.ones(rows * columns, dtype=np.bool_)
    taken = (taken_px // cell).astype(np.int64)
    in_grid = (taken[:, 0] < columns) & (taken[:, 1] < rows)
    free[taken[in_grid, 1] * columns + taken[in_grid, 0]] = False
    keep = free & (quality > config.corner_quality)
    return np.asarray(np.column_stack([u, v])[keep], dtype=np.float64)


def _inside(uv_px: np.ndarray, grey: ImageArray, *, margin_px: int) -> BoolArray:
    height, width = grey.shape
    u, v = uv_px[:, 0], uv_px[:, 1]
    inside: BoolArray = (
        (u >= margin_px) & (u < width - margin_px) & (v >= margin_px) & (v < height - margin_px)
    )
    return inside
