"""The story of mapping one session: where the head was, what stood there, what was looked at."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final

import numpy as np

from gazemap.gaze.cast import cast_fixations, in_scene_image
from gazemap.gaze.config import FixationConfig, GazeNoise, OffsetConfig
from gazemap.gaze.detect import detect_fixations
from gazemap.gaze.directions import poses_at
from gazemap.gaze.flow import ImageMotion, image_motion
from gazemap.gaze.offset import estimate_gaze_offset
from gazemap.geometry.arrays import ImageArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Overhead, Pose, World
from gazemap.ports import Progress, Session
from gazemap.scene.build import build_scene, table_outline
from gazemap.scene.cast import SceneCaster
from gazemap.scene.config import SceneConfig
from gazemap.scene.table_matches import match_table
from gazemap.session.gaze_camera import gaze_camera_of
from gazemap.slam.config import SlamConfig
from gazemap.slam.offline import map_session
from gazemap.slam.tag_alignment import locate_static_camera, pose_from_points
from gazemap.types.fixation import Fixation3D, GazeOffset
from gazemap.types.scene import SceneModel
from gazemap.types.session import Fixation
from gazemap.types.slam import SlamResult
from gazemap.types.tracking import Trajectory

# A fixed camera is located from images this far apart; an arm covers no tag in most of them.
_OVERHEAD_STRIDE: Final = 10
NO_OFFSET: Final = GazeOffset(
    azimuth_rad=0.0,
    elevation_rad=0.0,
    azimuth_sigma_rad=float(np.radians(OffsetConfig().unknown_sigma_deg)),
    elevation_sigma_rad=float(np.radians(OffsetConfig().unknown_sigma_deg)),
    is_applied=False,
)


class FixationSource(StrEnum):
    """Whose fixations are cast."""

    DEVICE = "device"
    OWN = "own"


class OffsetMode(StrEnum):
    """Whether the session's constant gaze error is looked for."""

    AUTO = "auto"
    OFF = "off"


@dataclass(frozen=True, slots=True, kw_only=True)
class MappingConfig:
    """The settings of each stage."""

    slam: SlamConfig = field(default_factory=SlamConfig)
    scene: SceneConfig = field(default_factory=SceneConfig)
    fixations: FixationConfig = field(default_factory=FixationConfig)
    offset: OffsetConfig = field(default_factory=OffsetConfig)
    noise: GazeNoise = field(default_factory=GazeNoise)
    source: FixationSource = FixationSource.DEVICE
    offset_mode: OffsetMode = OffsetMode.AUTO


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Located:
    """Where the cameras were."""

    slam: SlamResult
    T_world_overhead: Pose[World, Overhead] | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Looks:
    """What was looked at, and the gaze error that was found on the way."""

    fixations: tuple[Fixation3D, ...]
    offset: GazeOffset


def locate_cameras(session: Session, config: MappingConfig, *, progress: Progress) -> Located:
    """Track the head camera and find the overhead camera by the tags, or by the table itself."""
    slam = map_session(session, config.slam, progress=progress)
    T_world_overhead = _locate_by_tags(session)
    if T_world_overhead is None:
        T_world_overhead = _locate_by_table(session, slam.trajectory, config)
    return Located(slam=slam, T_world_overhead=T_world_overhead)


def _locate_by_tags(session: Session) -> Pose[World, Overhead] | None:
    camera, layout = session.overhead_camera, session.data.tags
    if camera is None or layout is None:
        return None
    return locate_static_camera(_spread_images(session), camera, layout=layout)


def _locate_by_table(
    session: Session, trajectory: Trajectory, config: MappingConfig
) -> Pose[World, Overhead] | None:
    """Find the overhead camera by what both cameras see of the table."""
    camera = session.overhead_camera
    if camera is None or not trajectory.t_ns.size:
        return None
    outline_xy = table_outline(session.data.tags, margin_m=config.scene.margin_m)
    matches = match_table(session, trajectory, outline_xy)
    if matches is None:
        return None
    flat = camera.normalize(matches.uv_px)
    return pose_from_points(matches.points_world, flat, focal_px=float(camera.K[0, 0]))


def _spread_images(session: Session) -> Iterator[ImageArray]:
    for frame in session.overhead_frames():
        if frame.index % _OVERHEAD_STRIDE == 0:
            yield frame.image


def model_scene(
    session: Session, located: Located, config: MappingConfig, *, progress: Progress
) -> SceneModel:
    """Build the surface and find the objects with their resting places."""
    return build_scene(
        session,
        located.slam.trajectory,
        points_world=located.slam.map.points_world,
        T_world_overhead=located.T_world_overhead,
        config=config.scene,
        progress=progress,
    )


def find_looks(
    session: Session, located: Located, scene: SceneModel, config: MappingConfig
) -> Looks:
    """Cast every fixation into the scene as it stood, after the gaze error was taken out."""
    fixations = fixations_of(session, located, config)
    camera, trajectory = _gaze_view(session, located)
    offset = NO_OFFSET
    if config.offset_mode is OffsetMode.AUTO:
        offset = estimate_gaze_offset(
            fixations,
            trajectory=trajectory,
            camera=camera,
            objects=scene.objects,
            config=config.offset,
        )
    overhead = None
    if session.overhead_camera is not None and located.T_world_overhead is not None:
        overhead = (session.overhead_camera, located.T_world_overhead)
    cast = cast_fixations(
        fixations,
        trajectory=trajectory,
        camera=camera,
        surface=SceneCaster(scene),
        offset=offset,
        noise=config.noise,
        overhead=overhead,
    )
    if camera is not located.slam.camera:
        path = located.slam.trajectory
        cast = tuple(
            in_scene_image(each, path.at(each.fixation.mid_ns), located.slam.camera)
            for each in cast
        )
    return Looks(fixations=cast, offset=offset)


def _gaze_view(session: Session, located: Located) -> tuple[Camera, Trajectory]:
    """Return the camera on whose images gaze is given, and its path."""
    slam, eyes = located.slam, gaze_camera_of(session.data)
    if eyes is None:
        return slam.camera, slam.trajectory
    return eyes.camera, slam.trajectory.carrying(eyes.T_cam_gaze)


def fixations_of(session: Session, located: Located, config: MappingConfig) -> tuple[Fixation, ...]:
    """Return the device's fixations where it gave any and they are wanted, else our own."""
    device, gaze = session.data.fixations, session.data.gaze
    if device is not None and config.source is FixationSource.DEVICE:
        return device
    if gaze is None:
        return ()
    camera, trajectory = _gaze_view(session, located)
    return detect_fixations(
        gaze,
        camera,
        trajectory,
        session.data.blinks,
        config.fixations,
        motion=_gaze_motion(session, located),
    )


def _gaze_motion(session: Session, located: Located) -> ImageMotion | None:
    """Return how the image of the camera of gaze moved where it has no pose, if it lacks any."""
    slam, eyes = located.slam, gaze_camera_of(session.data)
    t_ns = np.array(session.scene_t_ns, dtype=np.int64)
    is_posed = poses_at(slam.trajectory, t_ns)[2]
    motion = image_motion(session.scene_frames(), t_ns, slam.camera, is_posed=is_posed)
    return motion if motion is None or eyes is None else motion.carrying(eyes.T_cam_gaze)
