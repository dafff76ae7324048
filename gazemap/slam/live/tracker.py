"""Live tracking: one frame in, one outcome out, never looking ahead."""

from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from gazemap.errors import InputError, SolverError
from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Pose
from gazemap.slam.grey import to_grey
from gazemap.slam.live.bootstrap import Bootstrap
from gazemap.slam.live.config import LiveConfig
from gazemap.slam.live.gyro import Gyroscope
from gazemap.slam.live.link import InlineLink, MappingLink
from gazemap.slam.live.mapper import Mapper
from gazemap.slam.live.messages import (
    KeyframeNote,
    LoadNote,
    MapUpdate,
    Note,
    Refused,
    Reply,
    SaveNote,
)
from gazemap.slam.live.motion import Motion
from gazemap.slam.live.notes import Notes, depth_of, distance_from_keyframes
from gazemap.slam.live.patches import Pyramid
from gazemap.slam.live.pose_tracker import FramePose, PoseTracker
from gazemap.slam.live.tag_start import TagStart
from gazemap.slam.live.warm_up import warm_up_tracking
from gazemap.slam.live.worker import ProcessLink
from gazemap.slam.moving import coarse_chroma
from gazemap.types.frame import Frame
from gazemap.types.map import MapEvent, MapEventKind
from gazemap.types.session import ImuSample, TagLayout
from gazemap.types.tracking import Lost, LostReason, Scale, Tracked, TrackingOutcome

# With so few of the points that a keyframe should show, the view has changed much.
_THIN_SHARE = 0.4
_THIN_GAP_FRAMES = 10
# For so long after a loss the last frame may be near enough to follow points from.
_FLOW_SPAN_NS = 2_000_000_000
# A map of so few keyframes that is lost was hardly good: another start is worth more than waiting.
_YOUNG_KEYFRAMES = 8
_YOUNG_PATIENCE_NS = 300_000_000


class LiveTracker:
    """Tracks a head camera frame by frame while a map grows beside it.

    Mapping runs in a child process that is spawned: a script that uses this needs the usual
    `if __name__ == "__main__"`. Close the tracker, or use it in a with block.
    """

    def __init__(
        self,
        camera: Camera,
        *,
        layout: TagLayout | None = None,
        config: LiveConfig | None = None,
        rng: np.random.Generator | None = None,
    ) -> None:
        """Start without a map.

        Args:
            camera: the head camera.
            layout: tags that set the world, or None.
            config: settings.
            rng: samples the hypotheses of a start; one with seed 0 by default.
        """
        self._config = config if config is not None else LiveConfig()
        warm_up_tracking()
        self._link = _linked(camera, layout, self._config)
        self._bootstrap = Bootstrap(
            camera,
            config=self._config.bootstrap,
            front_end=self._config.front_end,
            rng=rng if rng is not None else np.random.default_rng(0),
        )
        self._tag_start = TagStart(camera, layout) if layout is not None else None
        self._poses = PoseTracker(camera, self._config.front_end)
        self._notes = Notes(self._config)
        self._gyroscope = Gyroscope()
        self._motion: Motion | None = None
        self._update: MapUpdate | None = None
        self._pending: tuple[KeyframeNote, int] | None = None
        self._events: list[MapEvent] = []
        self._newest_map_id = -1
        self._frame_count = 0
        self._keyframe_frame = 0
        self._lost_since_ns: int | None = None

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
        self._link.close()

    @property
    def update(self) -> MapUpdate | None:
        """The map as mapping last sent it."""
        return self._update

    @property
    def map_id(self) -> int:
        """Which map is tracked."""
        return self._update.map_id if self._update is not None else 0

    @property
    def scale(self) -> Scale:
        """Whether the map is metric; before there is one, poses come from tags, which are."""
        if self._update is not None:
            return self._update.scale
        return Scale.ARBITRARY if self._tag_start is None else Scale.METRIC

    def points_world(self) -> FloatArray:
        """Return the points (N, 3) of the map as it is now."""
        return self._poses.landmarks.points_world

    def moving_mask(self) -> BoolArray:
        """Return which parts (h, w) of the latest frame hold what moves by itself, coarsely."""
        return self._poses.moving.is_moving

    def take_events(self) -> tuple[MapEvent, ...]:
        """Return what happened to the map since the last call."""
        events, self._events = tuple(self._events), []
        return events

    def save(self, path: Path) -> None:
        """Write the map to a file, whole or not at all; mapping is waited for."""
        self._receive(wait=True)
        self._ask(SaveNote(path=path))

    def load(self, path: Path) -> None:
        """Go on in a map that was saved; the first frame that is recognised has a pose in it.

        Raises:
            InputError: if the file cannot be used.
        """
        reply = self._ask(LoadNote(path=path))
        if isinstance(reply, MapUpdate):
            self._notes.start_after(reply)
            self._motion = Motion(Pose.identity(), 0, self._gyroscope)
            self._lost_since_ns = reply.events[0].t_ns
            self._take(reply)

    def inertial(self, sample: ImuSample) -> None:
        """Take a sample of an IMU that is fixed to the camera, before the frames it precedes."""
        self._gyroscope.add(sample)

    def track(self, frame: Frame) -> TrackingOutcome:
        """Return where the camera was, from this frame and those before it."""
        grey = to_grey(frame.image)
        self._frame_count += 1
        self._receive()
        if float(grey[::4, ::4].std()) < self._config.front_end.blank_contrast:
            return self._lost(frame.t_ns, LostReason.BLANK)
        if self._motion is None:
            return self._begin(grey, frame.t_ns)
        found = self._found(grey, frame.t_ns, self._motion)
        if isinstance(found, LostReason):
            self._lost(frame.t_ns, found)
            return self._begin_anew(grey, frame.t_ns, found)
        self._motion.observe(found.fit.T_cam_world, frame.t_ns)
        self._poses.moving.update(found.votes, coarse_chroma(frame.image))
        if self._wants_keyframe(found):
            note = self._notes.keyframe(
                self._poses, found, grey=grey, twist=self._motion.twist, t_ns=frame.t_ns
            )
            self._link.send(note)
            self._pending = (note, self._frame_count)
            self._keyframe_frame = self._frame_count
        return self._tracked(found, frame.t_ns)

    def _found(self, grey: ImageArray, t_ns: int, motion: Motion) -> FramePose | LostReason:
        pyramid = Pyramid.of(grey)
        lost_ns = 0 if self._lost_since_ns is None else t_ns - self._lost_since_ns
        if lost_ns < _FLOW_SPAN_NS:
            found = self._poses.pose(grey, pyramid, motion, t_ns)
            if isinstance(found, FramePose) and (lost_ns == 0 or found.is_sure):
                return found
        return self._poses.relocalise(grey, pyramid)

    def _tracked(self, found: FramePose, t_ns: int) -> Tracked:
        was_lost = self._lost_since_ns is not None
        if was_lost:
            self._lost_since_ns = None
            self._bootstrap.reset()
            self._say(MapEventKind.RELOCALISED, t_ns)
        return Tracked(
            t_ns=t_ns,
            T_world_cam=found.fit.T_cam_world.inverse(),
            cov_cam=found.fit.cov_cam,
            map_id=self.map_id,
            is_relocalised=was_lost,
        )

    def _lost(self, t_ns: int, reason: LostReason) -> Lost:
        if self._motion is not None and self._lost_since_ns is None:
            self._motion.rest()
            self._lost_since_ns = t_ns
            self._say(MapEventKind.LOST, t_ns)
        return Lost(t_ns=t_ns, reason=reason)

    def _say(self, kind: MapEventKind, t_ns: int) -> None:
        self._events.append(
            MapEvent(kind=kind, t_ns=t_ns, map_id=self.map_id, old_map_id=self.map_id)
        )

    def _begin_anew(self, grey: ImageArray, t_ns: int, reason: LostReason) -> TrackingOutcome:
        """Start another map when the way back was not found for long."""
        patience_ns = int(self._config.new_map_after_s * 1e9)
        if self._update is not None and len(self._update.keyframe_centres_world) < _YOUNG_KEYFRAMES:
            patience_ns = min(patience_ns, _YOUNG_PATIENCE_NS)
        if self._lost_since_ns is None or t_ns - self._lost_since_ns < patience_ns:
            return Lost(t_ns=t_ns, reason=reason)
        self._receive(wait=True)
        return self._begin(grey, t_ns)

    def _begin(self, grey: ImageArray, t_ns: int) -> TrackingOutcome:
        start = self._bootstrap.push(grey, t_ns)
        if start is None:
            return self._by_tags(grey, t_ns)
        reply = self._ask(self._notes.start(start, map_id=self._newest_map_id + 1))
        if not isinstance(reply, MapUpdate):
            return self._by_tags(grey, t_ns)
        self._bootstrap.reset()
        self._motion = Motion(reply.T_cam_world, t_ns, self._gyroscope)
        self._lost_since_ns = None
        self._poses.forget_frame()
        self._take(reply)
        found = self._poses.pose(grey, Pyramid.of(grey), self._motion, t_ns)
        if isinstance(found, LostReason):
            return self._lost(t_ns, found)
        return self._tracked(found, t_ns)

    def _by_tags(self, grey: ImageArray, t_ns: int) -> TrackingOutcome:
        """Return the pose that the tags give while there is no map."""
        is_their_world = self._update is None or self._update.scale is Scale.METRIC
        fit = self._tag_start.pose(grey) if self._tag_start and is_their_world else None
        if fit is None:
            return Lost(t_ns=t_ns, reason=LostReason.STARTING)
        return Tracked(
            t_ns=t_ns,
            T_world_cam=fit.T_cam_world.inverse(),
            cov_cam=fit.cov_cam,
            map_id=max(self._newest_map_id, 0),
        )

    def _ask(self, note: Note) -> Reply:
        """Send a note and wait for its reply; no keyframe is pending then."""
        self._link.send(note)
        reply = self._link.wait()
        if isinstance(reply, Refused):
            raise InputError(reply.what, where=reply.where, todo=reply.todo)
        return reply

    def _receive(self, *, wait: bool = False) -> None:
        """Take over the map that the last keyframe led to, if it is time."""
        if self._pending is None:
            return
        lag = self._config.lag_frames
        is_due = lag is not None and self._frame_count - self._pending[1] >= lag
        if wait or is_due:
            reply: Reply | None = self._link.wait()
        else:
            reply = self._link.poll() if lag is None else None
        if reply is None:
            return
        if not isinstance(reply, MapUpdate):
            raise SolverError(f"mapping: a map was expected, got {type(reply).__name__}")
        note, self._pending = self._pending[0], None
        self._correct(note, reply)
        self._take(reply)

    def _take(self, update: MapUpdate) -> None:
        self._update = update
        self._newest_map_id = max(self._newest_map_id, update.map_id)
        self._events.extend(update.events)
        self._poses.take(update)

    def _correct(self, note: KeyframeNote, update: MapUpdate) -> None:
        """Move the latest pose with the map: it keeps its place beside the keyframe."""
        if self._motion is None:
            return
        T_keyframe = note.T_cam_world
        for event in update.events:
            if event.S_new_old is not None:
                self._motion.transform(event.S_new_old)
                self._poses.transform(event.S_new_old)
                T_keyframe = event.S_new_old.transform_pose(T_keyframe.inverse()).inverse()
        T_now_keyframe = self._motion.T_cam_world @ T_keyframe.inverse()
        self._motion.T_cam_world = T_now_keyframe @ update.T_cam_world

    def _wants_keyframe(self, found: FramePose) -> bool:
        config = self._config.mapping
        gap = self._frame_count - self._keyframe_frame
        if self._pending is not None or gap < config.keyframe_gap_frames or self._update is None:
            return False
        distance = distance_from_keyframes(
            self._update, found.fit.T_cam_world.inverse(), depth=depth_of(self._poses, found)
        )
        few = _THIN_SHARE * self._config.front_end.aligned_landmarks
        is_thin = len(found.rows) < few and gap > _THIN_GAP_FRAMES
        return distance > config.keyframe_distance or is_thin


def _linked(camera: Camera, layout: TagLayout | None, config: LiveConfig) -> MappingLink:
    if config.in_process:
        return InlineLink(Mapper(camera, layout=layout, config=config))
    return ProcessLink(camera, layout=layout, config=config)
