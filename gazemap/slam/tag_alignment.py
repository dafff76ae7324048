"""Where the tags put the world: a moving camera's map and a fixed camera's pose."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from gazemap.geometry.align import Similarity, fit_similarity
from gazemap.geometry.arrays import FloatArray, ImageArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Overhead, Pose, World
from gazemap.slam.tags import TagDetector, TagView
from gazemap.types.session import TagLayout

_CAUCHY_PX: Final = 0.3
_WORST_RESIDUAL_PX: Final = 2.0


class Map:
    """The frame of a map before anything metric was seen: origin, heading and scale are free."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TagSighting:
    """A tag as a posed camera of the map saw it."""

    T_map_cam: Pose[Map, Cam]
    view: TagView


def align_to_tags(
    sightings: Sequence[TagSighting], layout: TagLayout, *, focal_px: float
) -> Similarity[World, Map] | None:
    """Return the similarity that puts the map into the world of the tags.

    It minimises the reprojection of all corners robustly: corners that are triangulated first
    would spend the accuracy on their depth.

    Args:
        sightings: tags in posed frames; those that are not in the layout are ignored.
        layout: where the tags are.
        focal_px: what turns x/z into pixels, for the robust loss.

    Returns:
        None where the tags that were seen do not fix the similarity, or contradict it.
    """
    corners_world = {tag.tag_id: tag.T_world_tag.transform(tag.corners_tag) for tag in layout.tags}
    used = [s for s in sightings if s.view.tag_id in corners_world]
    first = _from_triangulated(used, corners_world)
    if first is None:
        return None
    world = np.array([corners_world[s.view.tag_id] for s in used])  # (S, 4, 3)
    seen = np.array([s.view.corners_norm for s in used])  # (S, 4, 2)
    R_map_cam = np.array([s.T_map_cam.R for s in used])
    p_map_cam = np.array([s.T_map_cam.t for s in used])

    def residuals_px(x: FloatArray) -> FloatArray:
        S_map_world = _similarity(x)
        in_map = S_map_world.transform(world)
        in_cam = np.einsum("nji,nkj->nki", R_map_cam, in_map - p_map_cam[:, None])
        flat = in_cam[..., :2] / np.maximum(in_cam[..., 2:], 1e-6)
        return np.asarray(focal_px * (flat - seen)).ravel()

    solved = least_squares(
        residuals_px, _parameters(first.inverse()), loss="cauchy", f_scale=_CAUCHY_PX, x_scale="jac"
    )
    if float(np.median(np.abs(residuals_px(solved.x)))) > _WORST_RESIDUAL_PX:
        return None
    return _similarity(solved.x).inverse()


def _parameters(S: Similarity[Map, World]) -> FloatArray:
    rotvec = Rotation.from_matrix(S.R).as_rotvec()
    return np.array([*rotvec, *S.t, np.log(S.scale)])


def _similarity(x: FloatArray) -> Similarity[Map, World]:
    R = Rotation.from_rotvec(x[:3]).as_matrix()
    return Similarity(scale=float(np.exp(x[6])), R=R, t=x[3:6])


def _from_triangulated(
    sightings: Sequence[TagSighting], corners_world: dict[int, FloatArray]
) -> Similarity[World, Map] | None:
    in_map, in_world = [], []
    for tag_id in sorted({s.view.tag_id for s in sightings}):
        views = [s for s in sightings if s.view.tag_id == tag_id]
        if len(views) < 2:
            continue
        for k in range(4):
            point = triangulate(
                [s.T_map_cam for s in views], np.array([s.view.corners_norm[k] for s in views])
            )
            if point is not None:
                in_map.append(point)
                in_world.append(corners_world[tag_id][k])
    return fit_similarity(np.array(in_map).reshape(-1, 3), np.array(in_world).reshape(-1, 3))


def triangulate(poses: Sequence[Pose[Map, Cam]], flat: FloatArray) -> FloatArray | None:
    """Return the point (3,) that views flat (N, 2) of posed cameras meet in; None if at infinity.

    The linear method, on rays x/z, y/z.
    """
    rows = []
    for T_map_cam, (x, y) in zip(poses, flat, strict=True):
        T_cam_map = T_map_cam.inverse().matrix
        rows += [x * T_cam_map[2] - T_cam_map[0], y * T_cam_map[2] - T_cam_map[1]]
    solution = np.linalg.svd(np.array(rows))[2][-1]
    if abs(solution[3]) < 1e-9:
        return None
    point: FloatArray = solution[:3] / solution[3]
    return point


def locate_static_camera(
    images: Iterable[ImageArray], camera: Camera, *, layout: TagLayout
) -> Pose[World, Overhead] | None:
    """Return the pose of a camera that does not move from the tags it sees; None without any.

    Corners are the medians over the images, so that an arm that covers a tag for a while, or
    touches its edge, does no harm.

    Args:
        images: grey or BGR; a handful spread over the recording is enough.
        camera: the camera that took them.
        layout: where the tags are.
    """
    detector = TagDetector(family=layout.family, camera=camera)
    seen: dict[int, list[FloatArray]] = {}
    for image in images:
        for view in detector.detect(image):
            seen.setdefault(view.tag_id, []).append(view.corners_norm)
    tags = [tag for tag in layout.tags if tag.tag_id in seen]
    if not tags:
        return None
    world = np.concatenate([tag.T_world_tag.transform(tag.corners_tag) for tag in tags])
    flat = np.concatenate([np.median(seen[tag.tag_id], axis=0) for tag in tags])
    return pose_from_points(world, flat, focal_px=float(camera.K[0, 0]))


def pose_from_points(
    world: FloatArray, flat: FloatArray, *, focal_px: float
) -> Pose[World, Overhead] | None:
    """Return a camera's pose from points and their views, the best of a plane's two.

    Args:
        world: (N, 3) the points.
        flat: (N, 2) their views, x/z and y/z.
        focal_px: turns x/z into pixels, in which a robust loss weighs what does not fit.
    """
    start = [
        np.concatenate([rotvec.ravel(), origin.ravel()])
        for rotvec, origin in zip(
            *cv2.solvePnPGeneric(world, flat, np.eye(3), None, flags=cv2.SOLVEPNP_SQPNP)[1:3],
            strict=True,
        )
    ]

    def residuals_px(x: FloatArray) -> FloatArray:
        in_cam = world @ Rotation.from_rotvec(x[:3]).as_matrix().T + x[3:]
        return np.asarray(focal_px * (in_cam[:, :2] / in_cam[:, 2:] - flat)).ravel()

    solved = [
        least_squares(residuals_px, x, loss="cauchy", f_scale=_CAUCHY_PX, x_scale="jac")
        for x in start
    ]
    if not solved:
        return None
    best = min(solved, key=lambda solution: float(solution.cost)).x
    T_cam_world: Pose[Overhead, World] = Pose.from_rotvec(best[:3], best[3:])
    return T_cam_world.inverse()
