"""From the map's own frame to world: by tags, or level and with an arbitrary scale."""

import numpy as np

from gazemap.geometry.align import Similarity
from gazemap.geometry.arrays import FloatArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.frame_path import FramePath, shutter_shift
from gazemap.slam.tag_alignment import Map, TagSighting, align_to_tags
from gazemap.slam.tags import TagDetector, TagView
from gazemap.slam.video import GreyVideo
from gazemap.types.session import TagLayout

_TAG_FRAMES = 48


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


def level(path: FramePath) -> Similarity[World, Map]:
    """Return the similarity of a world whose z axis is the cameras' mean up, without a scale.

    Its origin is the first camera, its y axis points where that camera looks.
    """
    posed = np.flatnonzero(path.is_posed)
    up: FloatArray = -path.R_cam_map[posed, 1].mean(axis=0)
    up /= np.linalg.norm(up)
    ahead = path.R_cam_map[posed[0], 2]
    ahead = ahead - up * (up @ ahead)
    ahead /= np.linalg.norm(ahead)
    R = np.stack([np.cross(ahead, up), ahead, up])
    first = posed[0]
    origin = -path.R_cam_map[first].T @ path.t_cam_map[first]
    return Similarity(scale=1.0, R=R, t=-R @ origin)
