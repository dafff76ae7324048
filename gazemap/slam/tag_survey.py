"""Tags that the layout does not place: where the map has them, and the scale of their size."""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from gazemap.geometry.align import Similarity
from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.pose import Pose, Tag, World
from gazemap.slam.tag_alignment import Map, TagSighting, triangulate
from gazemap.types.session import LayoutTag

_FEWEST_VIEWS: Final = 4
_LEAST_PARALLAX_RAD: Final = float(np.radians(3.0))
_WORST_PX: Final = 1.5
# Sides and diagonals of what is taken for a square differ by no more.
_WORST_SHAPE: Final = 0.06


def tag_corners(sightings: Sequence[TagSighting], focal_px: float) -> dict[int, FloatArray]:
    """Return the corners (4, 3) of each tag that the map fixes, in the map's frame.

    A tag that moved, or one of two with the same number, is no square or misses its views.

    Args:
        sightings: tags in posed frames.
        focal_px: what turns x/z into pixels.
    """
    placed = {}
    for tag_id in sorted({s.view.tag_id for s in sightings}):
        views = [s for s in sightings if s.view.tag_id == tag_id]
        if len(views) < _FEWEST_VIEWS:
            continue
        poses = [s.T_map_cam for s in views]
        flat = np.array([s.view.corners_norm for s in views])  # (V, 4, 2)
        corners = [triangulate(poses, flat[:, k]) for k in range(4)]
        found = np.array([c for c in corners if c is not None])
        if len(found) == 4 and _fits(found, poses_of(views), flat, focal_px=focal_px):
            placed[tag_id] = found
    return placed


def poses_of(views: Sequence[TagSighting]) -> tuple[FloatArray, FloatArray]:
    """Return the rotations (V, 3, 3) and centres (V, 3) of the cameras in the map."""
    return np.array([s.T_map_cam.R for s in views]), np.array([s.T_map_cam.t for s in views])


def _fits(
    corners: FloatArray, cameras: tuple[FloatArray, FloatArray], flat: FloatArray, *,
    focal_px: float,
) -> bool:  # fmt: skip
    """Return whether corners (4, 3) are a square that its views (V, 4, 2) see well."""
    R, centre = cameras
    rays = corners.mean(axis=0) - centre
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    parallax = float(np.arccos(np.clip((rays @ rays.T).min(), -1, 1)))
    in_cam = np.einsum("vji,vkj->vki", R, corners[None] - centre[:, None])
    if parallax < _LEAST_PARALLAX_RAD or (in_cam[..., 2] < 1e-6).any():
        return False
    off_px = focal_px * np.linalg.norm(in_cam[..., :2] / in_cam[..., 2:] - flat, axis=2)
    sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    diagonals = np.linalg.norm(corners[:2] - corners[2:], axis=1) / np.sqrt(2)
    lengths = np.concatenate([sides, diagonals])
    is_square = float(np.abs(lengths / lengths.mean() - 1).max()) < _WORST_SHAPE
    return is_square and float(np.median(off_px)) < _WORST_PX


def side(corners: FloatArray) -> float:
    """Return the mean side of a square's corners (4, 3)."""
    return float(np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1).mean())


def scale_from_size(corners_map: Mapping[int, FloatArray], *, size_m: float) -> float | None:
    """Return metres per unit of the map from tags of one known size; None without any."""
    if not corners_map:
        return None
    return size_m / float(np.median([side(corners) for corners in corners_map.values()]))


def surveyed_tags(
    corners_map: Mapping[int, FloatArray], S_world_map: Similarity[World, Map]
) -> tuple[LayoutTag, ...]:
    """Return tags with their size and place in world, by ascending id."""
    tags = []
    for tag_id, corners in sorted(corners_map.items()):
        top_left, top_right, bottom_right, bottom_left = world = S_world_map.transform(corners)
        x = top_right + bottom_right - top_left - bottom_left
        y = top_left + top_right - bottom_left - bottom_right
        x = x / np.linalg.norm(x)
        y = y - x * (x @ y)
        y = y / np.linalg.norm(y)
        T_world_tag: Pose[World, Tag] = Pose(
            R=np.column_stack([x, y, np.cross(x, y)]), t=world.mean(axis=0)
        )
        tags.append(LayoutTag(tag_id=tag_id, size_m=side(world), T_world_tag=T_world_tag))
    return tuple(tags)
