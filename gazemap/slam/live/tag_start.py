"""Poses from the tags alone, for the frames before there is a map."""

import cv2
import numpy as np

from gazemap.geometry.arrays import FloatArray, ImageArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.live.refine import PoseFit, PoseProblem, refine_pose
from gazemap.slam.tags import TagDetector
from gazemap.types.session import TagLayout

_CORNER_SIGMA_PX = 0.3
_WORST_ERROR_PX = 2.0
# A plane seen from afar has two poses; the second must fit worse than the first by so much.
_LEAST_AMBIGUITY_RATIO = 2.5


class TagStart:
    """Poses a camera by the tags of the layout, from the first frame that shows them well."""

    def __init__(self, camera: Camera, layout: TagLayout) -> None:
        """Prepare the detector."""
        self._camera = camera
        self._detector = TagDetector(family=layout.family, camera=camera)
        self._corners_world = {
            tag.tag_id: tag.T_world_tag.transform(tag.corners_tag) for tag in layout.tags
        }

    def pose(self, grey: ImageArray) -> PoseFit | None:
        """Return the pose; None where the tags do not fix it, or leave two."""
        views = [v for v in self._detector.detect(grey) if v.tag_id in self._corners_world]
        if not views:
            return None
        world = np.concatenate([self._corners_world[v.tag_id] for v in views])
        flat = np.concatenate([v.corners_norm for v in views])
        fits = [
            (_rms(fit), fit)
            for fit in (self._refined(T, world, flat) for T in _candidates(world, flat))
            if fit is not None
        ]
        if not fits:
            return None
        fits.sort(key=lambda pair: pair[0])
        error, best = fits[0]
        if error * _CORNER_SIGMA_PX > _WORST_ERROR_PX:
            return None
        for other_error, other in fits[1:]:
            turn = best.T_cam_world.R @ other.T_cam_world.R.T
            differs = float(np.trace(turn)) < 1 + 2 * np.cos(np.radians(2.0))
            if differs and other_error < _LEAST_AMBIGUITY_RATIO * max(error, 0.5):
                return None
        return best

    def _refined(
        self, start: Pose[Cam, World], world: FloatArray, flat: FloatArray
    ) -> PoseFit | None:
        problem = PoseProblem(
            points_world=world,
            xy=flat,
            sigma=np.full(len(flat), _CORNER_SIGMA_PX / float(self._camera.K[0, 0])),
            dt_s=np.zeros(len(flat)),
            twist=np.zeros(6),
        )
        return refine_pose(start, problem, cauchy=3.0)


def _rms(fit: PoseFit) -> float:
    return float(np.sqrt((np.minimum(fit.error, 1e3) ** 2).mean()))


def _candidates(world: FloatArray, flat: FloatArray) -> list[Pose[Cam, World]]:
    """Return the poses that a plane of points allows, which is what tags mostly lie in."""
    poses: list[Pose[Cam, World]] = []
    spread = np.linalg.svd(world - world.mean(axis=0))[1]
    is_plane = bool(spread[2] < 1e-3 * spread[0])
    for method in (cv2.SOLVEPNP_SQPNP, *((cv2.SOLVEPNP_IPPE,) if is_plane else ())):
        solved = cv2.solvePnPGeneric(world, flat, np.eye(3), None, flags=method)
        for rotvec, origin in zip(solved[1], solved[2], strict=True):
            poses.append(Pose.from_rotvec(np.ravel(rotvec), np.ravel(origin)))
    return poses
