"""Map points found again in any frame by one fixed reference patch each.

Corners that are followed from frame to frame drift; a patch that is always compared with the same
reference does not, and that is what makes the map accurate. Position and affine warp are predicted
from the poses (the patch is taken as a plane that faces its reference camera), then the position is
refined by inverse-compositional Lucas-Kanade under gain and offset.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.slam.config import PatchConfig
from gazemap.slam.frame_path import shutter_shift
from gazemap.slam.patch_kernels import Windows, align, cut, no_references

_LEVELS = 2
_LARGEST_WARP = 2.2
_SMALLEST_WARP = 0.45
_PLANE_STEP_PX = 3.0
_STEEPEST_COSINE = 0.5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PatchViews:
    """The points found in one frame.

    Attributes:
        point: (N,) index of the point.
        uv_px: (N, 2) where, on the distorted image.
        zncc: (N,) correlation with the reference.
    """

    point: IntArray
    uv_px: FloatArray
    zncc: FloatArray


class PatchAtlas:
    """The reference patches of all points."""

    def __init__(self, camera: Camera, *, uv_px: FloatArray, config: PatchConfig) -> None:
        """Make room for the patches.

        Args:
            camera: the head camera.
            uv_px: (P, 2) centre of each patch in its reference frame.
            config: sizes and thresholds.
        """
        count = len(uv_px)
        self._camera, self._config, self._uv_px = camera, config, uv_px
        weight = _gaussian(config.half_px)
        self._levels = [no_references(count, weight) for _ in range(_LEVELS)]
        self._plane_map = np.zeros((count, 3, 3))
        self._facing_map = np.zeros((count, 3))
        step = np.array([[0.0, 0.0], [_PLANE_STEP_PX, 0.0], [0.0, _PLANE_STEP_PX]])
        flat = camera.normalize((uv_px[:, None] + step).reshape(-1, 2)).reshape(count, 3, 2)
        self._ray_ref = np.concatenate([flat, np.ones((count, 3, 1))], axis=2)

    def take_references(self, grey: ImageArray, points: IntArray) -> None:
        """Cut the patches of points (N,) whose reference frame is this one."""
        for level, image in enumerate(_pyramid(grey)):
            cut(image, self._uv_px[points] / 2**level, points, self._levels[level])

    def place(self, points_map: FloatArray, R_ref_map: FloatArray, t_ref_map: FloatArray) -> None:
        """Set the planes of all points from their positions and reference poses.

        Args:
            points_map: (P, 3).
            R_ref_map: (P, 3, 3) of each point's reference frame.
            t_ref_map: (P, 3).
        """
        in_ref = np.einsum("nij,nj->ni", R_ref_map, points_map) + t_ref_map
        normal = in_ref / np.linalg.norm(in_ref, axis=1, keepdims=True)
        reach = np.einsum("ni,ni->n", normal, in_ref)[:, None] / np.einsum(
            "ni,nki->nk", normal, self._ray_ref
        )
        plane_ref = self._ray_ref * reach[..., None]
        # The point itself, not its ray through a pixel that may be a hair off it.
        plane_ref += (in_ref - plane_ref[:, 0])[:, None]
        self._facing_map = -np.einsum("nji,nj->ni", R_ref_map, normal)
        self._plane_map = np.einsum("nji,nkj->nki", R_ref_map, plane_ref - t_ref_map[:, None])

    def find(
        self,
        grey: ImageArray,
        R_cam_map: FloatArray,
        t_cam_map: FloatArray,
        *,
        twist: FloatArray | None = None,
    ) -> PatchViews:
        """Return the points that a frame shows.

        Args:
            grey: (height, width).
            R_cam_map: (3, 3) of its pose, good to a few pixels.
            t_cam_map: (3,).
            twist: (6,) motion per second as a left tangent, where the shutter rolls.
        """
        points, uv_px, warp = self._predict(R_cam_map, t_cam_map)
        if twist is not None and self._camera.readout_s:
            uv_px = uv_px + self._rolled(points, uv_px, R_cam_map, t_cam_map, twist=twist)
        images = _pyramid(grey)
        found_px, zncc = self._refine(images[0], 0, points=points, start_px=uv_px, warp=warp)
        missed = np.flatnonzero(zncc < self._config.zncc)
        coarse_px, coarse_zncc = self._refine(
            images[1], 1, points=points[missed], start_px=uv_px[missed] / 2, warp=warp[missed]
        )
        again = coarse_zncc > self._config.zncc - 0.1
        retry = missed[again]
        found_px[retry], zncc[retry] = self._refine(
            images[0], 0, points=points[retry], start_px=2 * coarse_px[again], warp=warp[retry]
        )
        keep = zncc >= self._config.zncc
        keep &= np.linalg.norm(found_px - uv_px, axis=1) < self._config.search_px
        return PatchViews(point=points[keep], uv_px=found_px[keep], zncc=zncc[keep])

    def _refine(
        self, image: ImageArray, level: int, *, points: IntArray, start_px: FloatArray,
        warp: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:  # fmt: skip
        windows = Windows(
            point=points,
            uv=start_px.copy(),
            zncc=np.full(len(points), -1.0),
            warp=np.ascontiguousarray(warp),
        )
        align(image, self._levels[level], windows, self._config.iterations)
        return windows.uv, windows.zncc

    def _predict(
        self, R_cam_map: FloatArray, t_cam_map: FloatArray
    ) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return the points (N,) in view, their pixels (N, 2) and warps (N, 2, 2)."""
        in_cam = self._plane_map @ R_cam_map.T + t_cam_map
        flat = in_cam[..., :2] / np.where(in_cam[..., 2:] > 1e-6, in_cam[..., 2:], np.nan)
        # Far off the axis a lens model may fold back into the image.
        ahead = np.flatnonzero((np.abs(flat) < self._widest_flat()).all(axis=(1, 2)))
        uv = self._camera.project(in_cam[ahead].reshape(-1, 3)).reshape(-1, 3, 2)
        warp = np.stack([uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]], axis=-1) / _PLANE_STEP_PX
        area = np.linalg.det(warp)
        keep = self._inside(uv[:, 0]) & self._is_facing(ahead, in_cam[ahead, 0], R_cam_map)
        keep &= (area > _SMALLEST_WARP**2) & (area < _LARGEST_WARP**2)
        return ahead[keep], uv[keep, 0], warp[keep]

    def _is_facing(self, points: IntArray, in_cam: FloatArray, R_cam_map: FloatArray) -> BoolArray:
        """Return which points (N,) are seen from about where their reference camera was."""
        to_reference = self._facing_map[points] @ R_cam_map.T
        cosine = -np.einsum("ni,ni->n", to_reference, in_cam) / np.linalg.norm(in_cam, axis=1)
        return np.asarray(cosine > _STEEPEST_COSINE)

    def _rolled(
        self, points: IntArray, uv_px: FloatArray, R_cam_map: FloatArray, t_cam_map: FloatArray,
        *, twist: FloatArray,
    ) -> FloatArray:  # fmt: skip
        """Return how far the rolling shutter moves predicted points, in pixels (N, 2)."""
        in_cam = self._plane_map[points, 0] @ R_cam_map.T + t_cam_map
        delay_s = self._camera.row_delay_ns(uv_px[:, 1]) / 1e9
        shift = shutter_shift(in_cam, twist=twist, delay_s=delay_s)
        return np.asarray(shift * [self._camera.K[0, 0], self._camera.K[1, 1]])

    def _widest_flat(self) -> float:
        width, height = self._camera.width_px, self._camera.height_px
        corners = np.array([[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]])
        return 1.1 * float(np.abs(self._camera.normalize(corners)).max())

    def _inside(self, uv_px: FloatArray) -> BoolArray:
        margin = self._config.half_px + 2
        low = (uv_px > margin).all(axis=1)
        u_end, v_end = self._camera.width_px - margin, self._camera.height_px - margin
        inside: BoolArray = low & (uv_px[:, 0] < u_end) & (uv_px[:, 1] < v_end)
        return inside


def _pyramid(grey: ImageArray) -> list[ImageArray]:
    return [grey, np.asarray(cv2.pyrDown(grey), dtype=np.uint8)]


def _gaussian(half_px: int) -> FloatArray:
    offset = np.arange(-half_px, half_px + 1)
    bell = np.exp(-0.5 * (offset / (0.6 * half_px)) ** 2)
    weight = np.outer(bell, bell).ravel()
    return np.asarray(weight / weight.sum())
