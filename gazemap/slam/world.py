"""From the map's own frame to world: by tags, or level and with an arbitrary scale."""

import numpy as np

from gazemap.geometry.align import Similarity
from gazemap.geometry.arrays import FloatArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.frame_path import FramePath, shutter_shift
from gazemap.slam.support import Support, find_support
from gazemap.slam.tag_alignment import Map, TagSighting, align_to_tags
from gazemap.slam.tags import TagDetector, TagView
from gazemap.slam.video import GreyVideo
from gazemap.types.session import TagLayout

_TAG_FRAMES = 48
# How far a camera on the head is from what the hands do, between sitting and standing.
_ARBITRARY_REACH_M = 0.75
# Flatter axes meet a table far away, or not at all.
_MIN_SINKING = 0.17


def find_tags(
    video: GreyVideo, camera: Camera, *, path: FramePath, frames: IntArray, family: str
) -> list[tuple[int, TagSighting]]:
    """Return the tags seen in some posed frames (K,), with the number of each frame."""
    detector = TagDetector(family=family, camera=camera)
    posed = frames[path.is_posed[frames]]
    spread = np.linspace(0, len(posed) - 1, min(len(posed), _TAG_FRAMES)).astype(int)
    wanted = set(posed[spread].tolist())
    sightings: list[tuple[int, TagSighting]] = []
    for index, grey in video:
        if index in wanted:
            T_cam_map: Pose[Cam, Map] = Pose(R=path.R_cam_map[index], t=path.t_cam_map[index])
            sightings += [
                (index, TagSighting(T_map_cam=T_cam_map.inverse(), view=view))
                for view in detector.detect(grey)
            ]
    return sightings


def align_by_tags(
    sightings: list[tuple[int, TagSighting]],
    camera: Camera,
    *,
    path: FramePath,
    layout: TagLayout,
) -> Similarity[World, Map] | None:
    """Return the similarity into the tags' world from what `find_tags` saw."""
    focal_px = float(camera.K[0, 0] + camera.K[1, 1]) / 2
    first = align_to_tags([s for _, s in sightings], layout, focal_px=focal_px)
    if first is None or not camera.readout_s:
        return first
    still = _without_shutter(sightings, path=path, camera=camera, layout=layout, S_world_map=first)
    return align_to_tags(still, layout, focal_px=focal_px)


def _without_shutter(
    sightings: list[tuple[int, TagSighting]],
    *,
    path: FramePath,
    camera: Camera,
    layout: TagLayout,
    S_world_map: Similarity[World, Map],
) -> list[TagSighting]:
    """Return the sightings as a global shutter would have seen them."""
    S_map_world = S_world_map.inverse()
    corners = {t.tag_id: S_map_world.transform(t.T_world_tag.transform(t.corners_tag))
               for t in layout.tags}  # fmt: skip
    twists = path.twists()
    still = []
    for index, sighting in sightings:
        view = sighting.view
        if view.tag_id not in corners:
            continue
        in_cam = corners[view.tag_id] @ path.R_cam_map[index].T + path.t_cam_map[index]
        delay_s = camera.row_delay_ns(view.corners_px[:, 1]) / 1e9
        shift = shutter_shift(in_cam, twist=twists[index], delay_s=delay_s)
        moved = TagView(
            tag_id=view.tag_id,
            corners_px=view.corners_px,
            corners_norm=view.corners_norm - shift,
        )
        still.append(TagSighting(T_map_cam=sighting.T_map_cam, view=moved))
    return still


def level(
    path: FramePath, points_map: FloatArray, *, metres: float | None
) -> Similarity[World, Map]:
    """Return the similarity of a world that no tag sets: z up, y where the wearer looks.

    Where most of the map lies on one level plane, that is z = 0 and the origin is where the wearer
    looks on it. Elsewhere up is the cameras' mean up and the origin is the first camera.

    Args:
        path: the cameras' path in the map.
        points_map: (M, 3) the map's points.
        metres: the length of the map's unit; None where nothing tells. The scale is then arbitrary,
            chosen so that the wearer looks at the plane from the distance of an arm's work, which
            what is tuned to a table's dimensions can live with.
    """
    posed = np.flatnonzero(path.is_posed)
    R_cam_map = path.R_cam_map[posed]
    origins = -np.einsum("fji,fj->fi", R_cam_map, path.t_cam_map[posed])
    up = _unit(-R_cam_map[:, 1].mean(axis=0))
    rng = np.random.default_rng(0)
    support = find_support(points_map, origins_map=origins, up_map=up, rng=rng)
    if support is None:
        R = _towards(up, R_cam_map[0, 2])
        scale = 1.0 if metres is None else metres
        return Similarity(scale=scale, R=R, t=-scale * R @ origins[0])
    # The image's up points away from a wearer who looks down, its middle from one who looks ahead.
    R = _towards(support.normal_map, (R_cam_map[:, 2] - R_cam_map[:, 1]).mean(axis=0))
    looked, reach = _looked_at(origins, R_cam_map[:, 2], support)
    scale = _ARBITRARY_REACH_M / reach if metres is None else metres
    return Similarity(scale=scale, R=R, t=-scale * R @ looked)


def _looked_at(
    origins: FloatArray, ahead: FloatArray, support: Support
) -> tuple[FloatArray, float]:
    """Return where optical axes (F, 3) meet the plane in the median, and from how far."""
    height = origins @ support.normal_map - support.offset
    sinking = -ahead @ support.normal_map
    meets = (sinking > _MIN_SINKING) & (height > 0)
    if not meets.any():
        foot = np.median(origins - height[:, None] * support.normal_map, axis=0)
        return foot, float(np.median(np.abs(height)))
    reach = height[meets] / sinking[meets]
    met = np.median(origins[meets] + reach[:, None] * ahead[meets], axis=0)
    on_plane = met - (met @ support.normal_map - support.offset) * support.normal_map
    return on_plane, float(np.median(reach))


def _unit(vector: FloatArray) -> FloatArray:
    return np.asarray(vector / np.linalg.norm(vector))


def _towards(up: FloatArray, ahead: FloatArray) -> FloatArray:
    """Return the rotation (3, 3) into axes with z up and y ahead."""
    level_ahead = _unit(ahead - up * (up @ ahead))
    return np.stack([np.cross(level_ahead, up), level_ahead, up])
