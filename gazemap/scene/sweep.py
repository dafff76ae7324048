"""Depth of one view from others: a plane sweep whose costs are smoothed along four paths.

Source:
    Collins 1996 (space sweep); Hirschmueller 2008 (semi-global matching), sec. 2.2.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from gazemap.geometry.arrays import BoolArray, FloatArray, IntArray
from gazemap.scene.config import SweepConfig

Float32Array = NDArray[np.float32]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StillView:
    """One moment of a camera, small, grey and without the lens's distortion.

    Attributes:
        grey: (h, w) float32, 0 to 255.
        bgr: (h, w, 3) uint8.
        K: (3, 3) of the small image.
        R_world_cam: (3, 3).
        p_world_cam: (3,).
    """

    grey: Float32Array
    bgr: NDArray[np.uint8]
    K: FloatArray
    R_world_cam: FloatArray
    p_world_cam: FloatArray

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width."""
        height, width = self.grey.shape
        return int(height), int(width)


def sweep_depth(
    view: StillView, others: list[StillView], *, near: float, far: float, config: SweepConfig
) -> Float32Array:
    """Return the depth (h, w) of a view along its optical axis, NaN where the others disagree.

    Args:
        view: whose depth is wanted.
        others: at least two views that see the same from elsewhere.
        near: the nearest plane that is tried.
        far: the farthest; planes lie evenly in inverse depth.
        config: settings.
    """
    inverse = np.linspace(1.0 / near, 1.0 / far, config.planes)
    alike = _alikeness(view, others, inverse, config)  # (D, h, w)
    cost = np.ascontiguousarray(np.moveaxis(1.0 - alike, 0, -1))  # (h, w, D)
    smooth = _smoothed(cost, config)
    best = smooth.argmin(axis=-1)
    depth = 1.0 / np.interp(_refined(smooth, best), np.arange(config.planes), inverse)
    at_end = (best == 0) | (best == config.planes - 1)
    agrees = np.take_along_axis(alike, best[None], axis=0)[0] > config.min_alikeness
    return np.where(agrees & ~at_end, depth, np.nan).astype(np.float32)


def _alikeness(
    view: StillView, others: list[StillView], inverse: FloatArray, config: SweepConfig
) -> Float32Array:
    """Return how alike (-1 to 1) the two best of the other views are at each plane (D, h, w).

    Two, because what is hidden from some of the views shall not count against a plane.
    """
    first = np.full((len(inverse), *view.shape), -1.0, dtype=np.float32)
    second = first.copy()
    patch = _Patches(view.grey, config)
    for other in others:
        R = other.R_world_cam.T @ view.R_world_cam
        t = other.R_world_cam.T @ (view.p_world_cam - other.p_world_cam)
        whole = np.ones(other.shape, dtype=np.float32)
        for k, closeness in enumerate(inverse):
            plane = R.copy()
            plane[:, 2] += t * closeness
            to_other = other.K @ plane @ np.linalg.inv(view.K)
            warped, seen = (_warped(x, to_other, view.shape) for x in (other.grey, whole))
            alike = np.where(seen > 0.99, patch.correlated(warped), np.float32(-1))
            np.maximum(second[k], np.minimum(first[k], alike), out=second[k])
            np.maximum(first[k], alike, out=first[k])
    first += second
    first /= 2
    return first


def _warped(image: Float32Array, to_image: FloatArray, shape: tuple[int, int]) -> Float32Array:
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return np.asarray(
        cv2.warpPerspective(image, to_image, shape[::-1], flags=flags), dtype=np.float32
    )


class _Patches:
    """The patches around all pixels of a view, to correlate others with."""

    def __init__(self, grey: Float32Array, config: SweepConfig) -> None:
        self._side, self._grey = (config.patch_px, config.patch_px), grey
        self._noise = np.float32(config.grey_sigma**2)
        self._mean = self._box(grey)
        self._variance = self._box(grey * grey) - self._mean**2 + self._noise

    def _box(self, image: Float32Array) -> Float32Array:
        return np.asarray(cv2.boxFilter(image, -1, self._side), dtype=np.float32)

    def correlated(self, other: Float32Array) -> Float32Array:
        """Return the correlation (h, w), near 0 where a patch shows no more than noise."""
        mean = self._box(other)
        variance = self._box(other * other) - mean * mean + self._noise
        shared = self._box(other * self._grey) - mean * self._mean
        both = np.sqrt(np.maximum(self._variance * variance, np.float32(1e-6)))
        return np.asarray(shared / both, dtype=np.float32)


def _smoothed(cost: Float32Array, config: SweepConfig) -> Float32Array:
    """Return costs (h, w, D) summed along the four paths down, up, right and left."""
    down = _along(cost, config)
    up = _along(cost[::-1], config)[::-1]
    turned = np.ascontiguousarray(cost.swapaxes(0, 1))
    right = _along(turned, config)
    left = _along(turned[::-1], config)[::-1]
    total: Float32Array = down + up + (right + left).swapaxes(0, 1)
    return total


def _along(cost: Float32Array, config: SweepConfig) -> Float32Array:
    """Return the cheapest way to each cell (n, m, D) along the first axis."""
    step, jump = np.float32(config.step_cost), np.float32(config.jump_cost)
    summed = np.empty_like(cost)
    summed[0] = cost[0]
    for k in range(1, len(cost)):
        before = summed[k - 1]
        least = before.min(axis=-1, keepdims=True)
        way = np.minimum(before, least + jump)
        np.minimum(way[:, 1:], before[:, :-1] + step, out=way[:, 1:])
        np.minimum(way[:, :-1], before[:, 1:] + step, out=way[:, :-1])
        summed[k] = cost[k] + way - least
    return summed


def _refined(cost: Float32Array, best: IntArray) -> FloatArray:
    """Return the plane (h, w) between planes at which a parabola through the costs is lowest."""
    inner = np.clip(best, 1, cost.shape[-1] - 2)
    low, middle, high = (
        np.take_along_axis(cost, (inner + d)[..., None], axis=-1)[..., 0] for d in (-1, 0, 1)
    )
    bend = np.maximum(low - 2 * middle + high, 1e-6)
    refined: FloatArray = inner + np.clip((low - high) / (2 * bend), -0.5, 0.5)
    return refined.astype(np.float64)


def points_of(view: StillView, depth: Float32Array) -> FloatArray:
    """Return the points (h, w, 3) in world of a depth image; NaN where it has none."""
    v, u = np.mgrid[0 : depth.shape[0], 0 : depth.shape[1]]
    rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(view.K).T
    points: FloatArray = (rays * depth[..., None]) @ view.R_world_cam.T + view.p_world_cam
    return points


def seen_depth(
    view: StillView, depth: Float32Array, points_world: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return how far points (..., 3) are from a view, and what its depth image has there.

    Both along the optical axis; NaN behind the view, beside its image or where it has none.
    """
    cam = (points_world.reshape(-1, 3) - view.p_world_cam) @ view.R_world_cam
    with np.errstate(divide="ignore", invalid="ignore"):
        uv_px = (cam @ view.K.T)[:, :2] / cam[:, 2:]
    inside = _inside(uv_px, view.shape) & (cam[:, 2] > 0)
    u, v = np.round(uv_px[inside]).astype(np.int64).T
    there = np.full(len(cam), np.nan)
    there[inside] = depth[v, u]
    shape = points_world.shape[:-1]
    return np.where(inside, cam[:, 2], np.nan).reshape(shape), there.reshape(shape)


def _inside(uv_px: FloatArray, shape: tuple[int, int]) -> BoolArray:
    with np.errstate(invalid="ignore"):
        inside = (uv_px > -0.5) & (uv_px < np.array([shape[1], shape[0]]) - 0.5)
    return np.asarray(inside.all(axis=1))
