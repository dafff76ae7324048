"""Corners that are followed until the map knows their depth."""

import numpy as np

from gazemap.geometry.align import Similarity
from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.live.landmarks import View, host_steps, see
from gazemap.slam.live.patches import LEVELS, STORED_SIDE, Pyramid, align_patches, cut_patches

_LEAST_CORRELATION = 0.75


class Candidates:
    """A table of corners with their references and a guess of their position.

    The guess, at the depth of the points around, is good enough to predict how patches look.
    """

    def __init__(self, camera: Camera) -> None:
        """Start empty."""
        self._camera = camera
        self.ids: IntArray = np.empty(0, np.int64)
        self.uv_px: FloatArray = np.empty((0, 2))
        self._guess_world: FloatArray = np.empty((0, 3))
        self._step_world: FloatArray = np.empty((0, 2, 3))
        self._facing_world: FloatArray = np.empty((0, 3))
        self._references: ImageArray = np.empty((0, LEVELS, STORED_SIDE, STORED_SIDE), np.uint8)

    def __len__(self) -> int:
        return len(self.ids)

    def add(
        self,
        ids: IntArray,
        uv_px: FloatArray,
        *,
        pyramid: Pyramid,
        T_world_cam: Pose[World, Cam],
        depth: float,
    ) -> None:
        """Add corners at even pixels (N, 2) of a keyframe; `depth` is a guess along the ray."""
        steps = T_world_cam.rotate(host_steps(self._camera, uv_px) * depth)
        self.ids = np.concatenate([self.ids, ids])
        self.uv_px = np.concatenate([self.uv_px, uv_px])
        self._guess_world = np.concatenate([self._guess_world, steps[:, 0] + T_world_cam.t])
        self._step_world = np.concatenate([self._step_world, steps[:, 1:]])
        self._facing_world = np.concatenate([self._facing_world, -steps[:, 0] / depth])
        self._references = np.concatenate([self._references, cut_patches(pyramid, uv_px)])

    def keep(self, chosen: BoolArray) -> None:
        """Drop all corners but the chosen."""
        self.ids, self.uv_px = self.ids[chosen], self.uv_px[chosen]
        self._guess_world, self._step_world = self._guess_world[chosen], self._step_world[chosen]
        self._facing_world = self._facing_world[chosen]
        self._references = self._references[chosen]

    def shift(self, before: Pose[Cam, World], after: Pose[Cam, World]) -> FloatArray:
        """Return by how much (N, 2) the corners are expected to move between two poses."""
        old = self._camera.project(before.transform(self._guess_world))
        new = self._camera.project(after.transform(self._guess_world))
        return np.nan_to_num(new - old)

    def aligned(
        self, pyramid: Pyramid, T_cam_world: Pose[Cam, World]
    ) -> tuple[IntArray, FloatArray]:
        """Return ids (M,) and pixels (M, 2) of the corners that still look like their reference."""
        view: View = see(
            self._camera, T_cam_world, self._guess_world, self._step_world, self._facing_world
        )
        uv_px, correlation = align_patches(
            pyramid, self._references[view.rows], view.from_image, self.uv_px[view.rows]
        )
        good = correlation > _LEAST_CORRELATION
        rows = view.rows[good]
        self.uv_px[rows] = uv_px[good]
        return self.ids[rows], uv_px[good]

    def transform(self, S_new_old: Similarity[World, World]) -> None:
        """Follow the map into its new world."""
        self._guess_world = S_new_old.transform(self._guess_world)
        self._step_world = S_new_old.scale * self._step_world @ S_new_old.R.T
        self._facing_world = self._facing_world @ S_new_old.R.T
