"""Compiles what is compiled before the first frame, which must not wait for it."""

import numpy as np

from gazemap.geometry.pose import Pose
from gazemap.slam.live.bundle import BundleProblem, adjust_bundle
from gazemap.slam.live.patches import Pyramid, align_patches, cut_patches
from gazemap.slam.live.places import describe
from gazemap.slam.live.refine import PoseProblem, refine_pose


def warm_up_tracking() -> None:
    """Align a patch and refine a pose."""
    grey = (np.indices((64, 64)).sum(axis=0) * 2).astype(np.uint8)
    pyramid = Pyramid.of(grey)
    uv_px = np.array([[32.0, 32.0]])
    align_patches(pyramid, cut_patches(pyramid, uv_px), np.eye(2)[None], uv_px, coarse=True)
    points = np.random.default_rng(0).uniform(-1, 1, (8, 3)) + np.array([0.0, 0.0, 4.0])
    problem = PoseProblem(
        points_world=points,
        xy=points[:, :2] / points[:, 2:],
        sigma=np.ones(8),
        dt_s=np.zeros(8),
        twist=np.zeros(6),
    )
    refine_pose(Pose.identity(), problem)
    describe(cut_patches(pyramid, uv_px))


def warm_up_mapping() -> None:
    """Adjust two keyframes of eight points."""
    warm_up_tracking()
    points = np.random.default_rng(0).uniform(-1, 1, (8, 3)) + np.array([0.0, 0.0, 4.0])
    flat = points[:, :2] / points[:, 2:]
    problem = BundleProblem(
        R=np.stack([np.eye(3)] * 2),
        t=np.zeros((2, 3)),
        twist=np.zeros((2, 6)),
        keyframe_free=np.array([False, True]),
        points_world=points,
        point_free=np.ones(8, bool),
        keyframe=np.tile([0, 1], 8),
        point=np.repeat(np.arange(8), 2),
        xy=np.repeat(flat, 2, axis=0),
        sigma=np.ones(16),
        dt_s=np.zeros(16),
    )
    adjust_bundle(problem, rounds=1)
