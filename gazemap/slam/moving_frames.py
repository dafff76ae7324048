"""The masks of moving things of a whole recording, once a first map has posed its frames."""

from dataclasses import dataclass

import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose
from gazemap.slam.frame_path import FramePath
from gazemap.slam.front import FollowedCorners, Skeleton
from gazemap.slam.moving import NO_VOTES, Followed, MaskGrid, MovingMask, Votes, votes_of
from gazemap.slam.patches import PatchViews
from gazemap.slam.tag_alignment import Map


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MovingFrames:
    """The masks (F, h, w) of all frames, and their cells."""

    is_moving: BoolArray
    grid: MaskGrid

    def covers(self, frames: IntArray | int, uv_px: FloatArray) -> BoolArray:
        """Return which pixels (N, 2), of frames (N,) or of one, are covered."""
        covered: BoolArray = self.is_moving[frames, *self.grid.cells(uv_px)]
        return covered

    def hide(self, skeleton: Skeleton) -> None:
        """Take the views of keyframes that are covered out of the valid ones."""
        structure = skeleton.structure
        frames = skeleton.frames[structure.keyframe]
        structure.is_valid &= ~self.covers(frames, skeleton.uv_px)

    def uncovered(self, frame: int, views: PatchViews) -> PatchViews:
        """Return the views of a frame that are not covered."""
        keep = ~self.covers(frame, views.uv_px)
        return PatchViews(point=views.point[keep], uv_px=views.uv_px[keep], zncc=views.zncc[keep])


def find_moving(
    followed: FollowedCorners, camera: Camera, *, skeleton: Skeleton, path: FramePath
) -> MovingFrames:
    """Return what moves in each frame, from how its corners moved since the frame before."""
    mask = MovingMask(width_px=camera.width_px, height_px=camera.height_px)
    masks = []
    for i, chroma in enumerate(followed.chroma):
        if i == 0 or not path.is_posed[i - 1 : i + 1].all():
            mask.forget()
        else:
            mask.update(_votes(followed, camera, i, skeleton=skeleton, path=path), chroma)
        masks.append(mask.is_moving)
    return MovingFrames(is_moving=np.array(masks), grid=mask.grid)


def _votes(
    followed: FollowedCorners, camera: Camera, i: int, *, skeleton: Skeleton, path: FramePath
) -> Votes:
    before, after = followed.corners[i - 1], followed.corners[i]
    _, old, new = np.intersect1d(
        before.track_id, after.track_id, assume_unique=True, return_indices=True
    )
    if len(old) == 0:
        return NO_VOTES
    structure, track = skeleton.structure, skeleton.track_of[before.track_id[old]]
    known = (track >= 0) & structure.has_point[track]
    depth = structure.points_map[track] @ path.R_cam_map[i - 1][2] + path.t_cam_map[i - 1][2]
    depth[~known | (depth <= 0)] = np.nan
    T_before: Pose[Cam, Map] = Pose(R=path.R_cam_map[i - 1], t=path.t_cam_map[i - 1])
    T_after: Pose[Cam, Map] = Pose(R=path.R_cam_map[i], t=path.t_cam_map[i])
    return votes_of(
        Followed(before_px=before.uv_px[old], after_px=after.uv_px[new], depth=depth),
        camera,
        T_after_before=T_after @ T_before.inverse(),
    )
