"""Where a finished map lies in world, and what tells its scale."""

from dataclasses import dataclass

from gazemap.geometry.align import Similarity
from gazemap.geometry.arrays import IntArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import World
from gazemap.ports import Session
from gazemap.slam.config import SlamConfig
from gazemap.slam.depth_scale import scale_from_depth
from gazemap.slam.frame_path import FramePath
from gazemap.slam.refinement import RefinedMap
from gazemap.slam.tag_alignment import Map, TagSighting
from gazemap.slam.tag_survey import scale_from_size, surveyed_tags, tag_corners
from gazemap.slam.video import GreyVideo
from gazemap.slam.world import align_by_tags, find_tags, level
from gazemap.types.session import LayoutTag, TagLayout
from gazemap.types.tracking import Scale


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PosedMap:
    """A map in its own frame: the video, the poses of all frames, the keyframes (K,), points."""

    video: GreyVideo
    camera: Camera
    path: FramePath
    frames: IntArray
    refined: RefinedMap

    @property
    def focal_px(self) -> float:
        """What turns x/z into pixels."""
        return float(self.camera.K[0, 0] + self.camera.K[1, 1]) / 2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Placement:
    """How a map lies in world; `surveyed_tags` are not in the layout."""

    S_world_map: Similarity[World, Map]
    scale: Scale
    surveyed_tags: tuple[LayoutTag, ...] = ()
    warnings: tuple[str, ...] = ()


def place(session: Session, posed: PosedMap, *, config: SlamConfig, use_tags: bool) -> Placement:
    """Put a map into the world of the layout, or level with what scale there is.

    The scale comes from the layout, else from depth images, else from the size of tags.
    """
    layout = session.data.tags if use_tags else None
    if layout is None and config.tag_size_m is None:
        return _level(posed, _depth_scale(session, posed))
    seen = find_tags(
        posed.video, posed.camera, path=posed.path, frames=posed.frames,
        family=layout.family if layout is not None else config.tag_family,
    )  # fmt: skip
    if layout is not None:
        S = align_by_tags(seen, posed.camera, path=posed.path, layout=layout)
        if S is not None:
            tags = surveyed_tags(tag_corners(_others(seen, layout), posed.focal_px), S)
            return Placement(S_world_map=S, scale=Scale.METRIC, surveyed_tags=tags)
    corners = tag_corners(_others(seen, None), posed.focal_px)
    metres = _depth_scale(session, posed)
    if metres is None and config.tag_size_m is not None:
        metres = scale_from_size(corners, size_m=config.tag_size_m)
    placed = _level(posed, metres)
    is_metric = placed.scale is Scale.METRIC
    return Placement(
        S_world_map=placed.S_world_map,
        scale=placed.scale,
        surveyed_tags=surveyed_tags(corners, placed.S_world_map) if is_metric else (),
        warnings=(
            ("the tags of the layout were not seen well enough to set the world",)
            if layout is not None
            else ()
        ),
    )


def _others(
    sightings: list[tuple[int, TagSighting]], layout: TagLayout | None
) -> list[TagSighting]:
    known = {tag.tag_id for tag in layout.tags} if layout is not None else set()
    return [sighting for _, sighting in sightings if sighting.view.tag_id not in known]


def _depth_scale(session: Session, posed: PosedMap) -> float | None:
    return scale_from_depth(
        session.scene_depth_frames(), path=posed.path, found=posed.refined.found,
        points_map=posed.refined.points_map, is_good=posed.refined.is_good,
    )  # fmt: skip


def _level(posed: PosedMap, metres: float | None) -> Placement:
    points_map = posed.refined.points_map[posed.refined.is_good]
    return Placement(
        S_world_map=level(posed.path, points_map, metres=metres),
        scale=Scale.ARBITRARY if metres is None else Scale.METRIC,
    )
