"""Mapping as it happens: frames and gaze go in; poses, objects and 3D fixations come out."""

from dataclasses import dataclass, field
from types import TracebackType
from typing import Final, Self

import numpy as np

from gazemap.gaze.config import FixationConfig, GazeNoise, OffsetConfig
from gazemap.geometry.arrays import ImageArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Overhead, Pose, World
from gazemap.live_looks import LiveFixations, LiveLooks, RecentPath
from gazemap.scene.build import table_outline
from gazemap.scene.cast import SceneCaster, open3d
from gazemap.scene.config import SceneConfig
from gazemap.scene.live import LiveObjects
from gazemap.scene.surface import table_mesh, with_boxes
from gazemap.session.gaze_camera import GazeCamera
from gazemap.slam.live.config import LiveConfig
from gazemap.slam.live.following import KeyframeFollower
from gazemap.slam.live.tracker import LiveTracker
from gazemap.slam.live.warm_up import warm_up_tracking
from gazemap.slam.tag_alignment import locate_static_camera
from gazemap.types.fixation import Fixation3D
from gazemap.types.frame import Frame
from gazemap.types.map import MapEvent
from gazemap.types.scene import SceneModel, SceneObject
from gazemap.types.session import Fixation, GazeSample, ImuSample, TagLayout
from gazemap.types.tracking import Scale, Tracked, TrackingOutcome

_OVERHEAD_IMAGES: Final = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveMappingConfig:
    """The settings of each stage."""

    tracking: LiveConfig = field(default_factory=LiveConfig)
    scene: SceneConfig = field(default_factory=SceneConfig)
    fixations: FixationConfig = field(default_factory=FixationConfig)
    offset: OffsetConfig = field(default_factory=OffsetConfig)
    noise: GazeNoise = field(default_factory=GazeNoise)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LiveRig:
    """What is known of the rig as it begins."""

    head_camera: Camera
    overhead_camera: Camera | None
    layout: TagLayout | None
    gaze_camera: GazeCamera | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class News:
    """What one input led to; fixations and objects may be new or corrected."""

    outcome: TrackingOutcome | None = None
    events: tuple[MapEvent, ...] = ()
    fixations: tuple[Fixation3D, ...] = ()
    objects: tuple[SceneObject, ...] = ()
    T_world_overhead: Pose[World, Overhead] | None = None


def warm_up() -> None:
    """Load and compile what the first frames would otherwise wait for."""
    open3d()
    warm_up_tracking()


class LiveMapping:
    """Maps a live rig, input by input; nothing later than an input is used."""

    def __init__(
        self, rig: LiveRig, config: LiveMappingConfig, *, rng: np.random.Generator
    ) -> None:
        """Start without a map."""
        self._rig, self._config = rig, config
        self._tracker = LiveTracker(
            rig.head_camera, layout=rig.layout, config=config.tracking, rng=rng
        )
        self._path = RecentPath()
        self._keyframes = KeyframeFollower()
        self._looks = LiveLooks(
            rig.head_camera, noise=config.noise, offset=config.offset, eyes=rig.gaze_camera
        )
        self._detector = LiveFixations(rig.head_camera, config.fixations, rig.gaze_camera)
        self._outline_xy = table_outline(rig.layout, margin_m=config.scene.margin_m)
        self._background = table_mesh(self._outline_xy)
        self._objects: LiveObjects | None = None
        self._overhead_images: list[ImageArray] = []
        self._last_view_ns = 0
        self._surface = SceneCaster(self.scene())

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Stop mapping."""
        self._tracker.close()

    @property
    def tracker(self) -> LiveTracker:
        """The head camera's tracker."""
        return self._tracker

    @property
    def looks(self) -> LiveLooks:
        """The fixations so far and the gaze error."""
        return self._looks

    def scene(self) -> SceneModel:
        """Return the scene as it is known now."""
        objects = () if self._objects is None else self._objects.objects
        overhead = self._looks.overhead
        return SceneModel(
            mesh=with_boxes(self._background, objects),
            background=self._background,
            objects=objects,
            T_world_overhead=None if overhead is None else overhead[1],
            surface_sigma_m=self._config.scene.surface_sigma_m,
        )

    def head_frame(self, frame: Frame) -> News:
        """Track a frame of the head camera; cast what was waiting for its pose."""
        outcome = self._tracker.track(frame)
        events = self._tracker.take_events()
        moved = self._follow(events)
        self._path.last_ns = frame.t_ns
        changed: list[SceneObject] = []
        if isinstance(outcome, Tracked):
            self._path.add(outcome)
            changed = self._show_head_view(frame, outcome)
        fixations = self._looks.cast_due(self._path, self._surface, scale=self._scale)
        corrected = self._correct(changed, moved)
        return News(
            outcome=outcome,
            events=events,
            fixations=(*fixations, *corrected),
            objects=tuple(changed),
        )

    def overhead_frame(self, frame: Frame) -> News:
        """See what came to rest or left in a frame of the overhead camera."""
        if self._objects is None:
            return News(T_world_overhead=self._locate_overhead(frame))
        changed = self._objects.add(frame)
        return News(objects=tuple(changed), fixations=tuple(self._correct(changed, set())))

    def inertial(self, sample: ImuSample) -> None:
        """Take in a sample of the IMU that is fixed to the head camera."""
        self._tracker.inertial(sample)

    def gaze(self, sample: GazeSample) -> None:
        """Take in a gaze sample of a device that detects no fixations itself."""
        for each in self._detector.add(sample, self._path, scale=self._scale):
            self._looks.add(each)

    def device_fixation(self, fixation: Fixation) -> None:
        """Take in a fixation that the device detected."""
        self._looks.add(fixation)

    def finish(self) -> News:
        """Settle what is open, at the end of a recording."""
        changed = [] if self._objects is None else self._objects.finish()
        cast = self._looks.cast_due(self._path, self._surface, scale=self._scale)
        corrected = self._correct(changed, set())
        return News(objects=tuple(changed), fixations=(*cast, *corrected))

    @property
    def _scale(self) -> Scale:
        return self._tracker.scale

    def _follow(self, events: tuple[MapEvent, ...]) -> set[int]:
        """Move what was published with the map; return which looks have moved."""
        for event in events:
            if event.S_new_old is not None:
                self._path.transform(
                    event.S_new_old, old_map_id=event.old_map_id, map_id=event.map_id
                )
        keyframes = self._keyframes.take(self._tracker.update, events)
        return set() if keyframes is None else self._looks.follow(keyframes)

    def _show_head_view(self, frame: Frame, outcome: Tracked) -> list[SceneObject]:
        """Show the objects a posed head frame, now and then: heights come from there."""
        period_ns = self._config.scene.head_period_s * 1e9
        is_metric = self._scale is Scale.METRIC
        if self._objects is None or not is_metric or frame.t_ns - self._last_view_ns < period_ns:
            return []
        self._last_view_ns = frame.t_ns
        return self._objects.add_view(frame, self._rig.head_camera, outcome.T_world_cam)

    def _correct(self, changed: list[SceneObject], moved: set[int]) -> list[Fixation3D]:
        """Cast again what the change of scene, map or gaze error may have moved."""
        if changed:
            self._surface = SceneCaster(self.scene())
        objects = () if self._objects is None else self._objects.objects
        has_new_offset = self._looks.estimate_offset(objects, scale=self._scale)
        if changed or has_new_offset:
            return self._looks.recast(self._surface)
        return self._looks.recast(self._surface, only=moved) if moved else []

    def _locate_overhead(self, frame: Frame) -> Pose[World, Overhead] | None:
        camera, layout = self._rig.overhead_camera, self._rig.layout
        if camera is None or layout is None:
            return None
        self._overhead_images = [*self._overhead_images, frame.image][-_OVERHEAD_IMAGES:]
        if len(self._overhead_images) < _OVERHEAD_IMAGES:
            return None
        located = locate_static_camera(self._overhead_images, camera, layout=layout)
        if located is None:
            return None
        self._looks.overhead = (camera, located)
        self._objects = LiveObjects(
            camera, located, self._config.scene, outline_xy=self._outline_xy, marks=layout
        )
        return located
