"""Live tracking: one frame in, one outcome out, never looking ahead."""

from types import TracebackType
from typing import Self

import numpy as np

from gazemap.geometry.arrays import FloatArray, ImageArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.grey import to_grey
from gazemap.slam.live.bootstrap import Bootstrap, Start
from gazemap.slam.live.config import LiveConfig
from gazemap.slam.live.corners import find_corners
from gazemap.slam.live.link import InlineLink, MappingLink
from gazemap.slam.live.mapper import Mapper
from gazemap.slam.live.messages import KeyframeNote, MapUpdate, StartNote
from gazemap.slam.live.motion import Motion
from gazemap.slam.live.patches import Pyramid
from gazemap.slam.live.pose_tracker import FramePose, PoseTracker
from gazemap.slam.live.warm_up import warm_up_tracking
from gazemap.slam.live.worker import ProcessLink
from gazemap.types.frame import Frame
from gazemap.types.map import MapEvent, MapEventKind
from gazemap.types.session import TagLayout
from gazemap.types.tracking import Lost, LostReason, Scale, Tracked, TrackingOutcome


class LiveTracker:
    """Tracks a head camera frame by frame while a map grows beside it."""

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
            rng: for what samples at random.
        """
        self._camera = camera
        self._config = config if config is not None else LiveConfig()
        self._rng = rng if rng is not None else np.random.default_rng(0)
        warm_up_tracking()
        self._link: MappingLink = self._linked(layout)
        self._bootstrap = Bootstrap(camera, self._config.bootstrap, self._config.front_end)
        self._poses = PoseTracker(camera, self._config.front_end)
        self._motion: Motion | None = None
        self._update: MapUpdate | None = None
        self._pending: tuple[KeyframeNote, int] | None = None
        self._events: list[MapEvent] = []
        self._next_id = 0
        self._next_keyframe = 0
        self._frame_count = 0
        self._keyframe_frame = 0
        self._was_lost = False

    def _linked(self, layout: TagLayout | None) -> MappingLink:
        if self._config.in_process:
            return InlineLink(Mapper(self._camera, layout=layout, config=self._config))
        return ProcessLink(self._camera, layout=layout, config=self._config)

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
    def map_id(self) -> int:
        """Which map is tracked."""
        return self._update.map_id if self._update is not None else 0

    @property
    def scale(self) -> Scale:
        """Whether the map is metric."""
        return self._update.scale if self._update is not None else Scale.ARBITRARY

    def points_world(self) -> FloatArray:
        """Return the points (N, 3) of the map as it is now."""
        return self._poses.landmarks.points_world

    def take_events(self) -> tuple[MapEvent, ...]:
        """Return what happened to the map since the last call."""
        events, self._events = tuple(self._events), []
        return events

    def track(self, frame: Frame) -> TrackingOutcome:
        """Return where the camera was, from this frame and those before it."""
        grey = to_grey(frame.image)
        self._frame_count += 1
        self._receive()
        if float(grey[::4, ::4].std()) < self._config.front_end.blank_contrast:
            return self._lost(frame.t_ns, LostReason.BLANK)
        if self._motion is None:
            return self._begin(grey, frame.t_ns)
        pyramid = Pyramid.of(grey)
        found = self._poses.pose(grey, pyramid, self._motion, frame.t_ns)
        if isinstance(found, LostReason):
            found = self._poses.relocalise(grey, pyramid)
        if isinstance(found, LostReason):
            return self._lost(frame.t_ns, found)
        self._motion.observe(found.fit.T_cam_world, frame.t_ns)
        if self._wants_keyframe(found):
            self._send_keyframe(grey, pyramid, found, frame.t_ns)
        return self._tracked(found, frame.t_ns)

    def _tracked(self, found: FramePose, t_ns: int) -> Tracked:
        was_lost, self._was_lost = self._was_lost, False
        if was_lost:
            self._say(MapEventKind.RELOCALISED, t_ns)
        return Tracked(
            t_ns=t_ns,
            T_world_cam=found.fit.T_cam_world.inverse(),
            cov_cam=found.fit.cov_cam,
            map_id=self.map_id,
            is_relocalised=was_lost,
        )

    def _lost(self, t_ns: int, reason: LostReason) -> Lost:
        if self._motion is not None:
            self._motion.rest()
            if not self._was_lost:
                self._say(MapEventKind.LOST, t_ns)
            self._was_lost = True
        return Lost(t_ns=t_ns, reason=reason)

    def _say(self, kind: MapEventKind, t_ns: int) -> None:
        self._events.append(
            MapEvent(kind=kind, t_ns=t_ns, map_id=self.map_id, old_map_id=self.map_id)
        )

    def _begin(self, grey: ImageArray, t_ns: int) -> TrackingOutcome:
        start = self._bootstrap.push(grey, t_ns)
        if start is None:
            return Lost(t_ns=t_ns, reason=LostReason.STARTING)
        self._link.send(self._start_note(start))
        reply = self._link.wait()
        if not isinstance(reply, MapUpdate):
            return Lost(t_ns=t_ns, reason=LostReason.STARTING)
        self._bootstrap.reset()
        self._motion = Motion(reply.T_cam_world, t_ns)
        self._take(reply)
        pyramid = Pyramid.of(grey)
        found = self._poses.pose(grey, pyramid, self._motion, t_ns)
        if isinstance(found, LostReason):
            return self._lost(t_ns, found)
        return self._tracked(found, t_ns)

    def _start_note(self, start: Start) -> StartNote:
        ids = self._new_ids(len(start.views[0].uv_px))
        none = np.empty(0, np.int64)
        notes = []
        for n, view in enumerate(start.views):
            notes.append(
                KeyframeNote(
                    keyframe_id=self._new_keyframe_id(),
                    t_ns=view.t_ns,
                    grey=view.grey,
                    T_cam_world=view.T_cam_world,
                    twist=np.zeros(6),
                    ids=ids if n > 0 else none,
                    uv_px=view.uv_px if n > 0 else np.empty((0, 2)),
                    sigma_px=np.full(len(ids) if n > 0 else 0, 1.0),
                    born_ids=ids if n == 0 else none,
                    born_uv_px=view.uv_px if n == 0 else np.empty((0, 2)),
                )
            )
        return StartNote(map_id=self.map_id, keyframes=tuple(notes))

    def _new_ids(self, count: int) -> IntArray:
        ids = np.arange(self._next_id, self._next_id + count)
        self._next_id += count
        return ids

    def _new_keyframe_id(self) -> int:
        self._next_keyframe += 1
        return self._next_keyframe - 1

    def _receive(self) -> None:
        """Take over the map that the last keyframe led to, if it is time."""
        if self._pending is None:
            return
        lag = self._config.lag_frames
        if lag is None:
            reply = self._link.poll()
        else:
            is_due = self._frame_count - self._pending[1] >= lag
            reply = self._link.wait() if is_due else None
        if not isinstance(reply, MapUpdate):
            return
        note, self._pending = self._pending[0], None
        self._correct(note, reply)
        self._take(reply)

    def _take(self, update: MapUpdate) -> None:
        self._update = update
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
        T_world_cam = found.fit.T_cam_world.inverse()
        points = self._poses.landmarks.points_world[found.rows]
        depth = float(np.median(np.linalg.norm(points - T_world_cam.t, axis=1)))
        moved = np.linalg.norm(self._update.keyframe_centres_world - T_world_cam.t, axis=1) / depth
        cosine = self._update.keyframe_axes_world @ T_world_cam.R[:, 2]
        turned = np.arccos(np.clip(cosine, -1.0, 1.0))
        is_new = float((moved + 0.5 * turned).min()) > config.keyframe_distance
        is_thin = len(found.rows) < 0.4 * self._config.front_end.aligned_landmarks and gap > 10
        return is_new or is_thin

    def _send_keyframe(
        self, grey: ImageArray, pyramid: Pyramid, found: FramePose, t_ns: int
    ) -> None:
        if self._motion is None:
            return
        T_cam_world: Pose[Cam, World] = found.fit.T_cam_world
        candidates = self._poses.candidates
        ids, uv_px = candidates.aligned(pyramid, T_cam_world)
        candidates.keep(np.isin(candidates.ids, ids))
        taken = np.concatenate([found.uv_px, uv_px])
        room = self._config.front_end.candidates - len(candidates)
        born_px = find_corners(grey, taken, count=room)
        born_ids = self._new_ids(len(born_px))
        points = self._poses.landmarks.points_world[found.rows]
        depth = float(np.median(np.linalg.norm(points - T_cam_world.inverse().t, axis=1)))
        candidates.add(
            born_ids, born_px, pyramid=pyramid, T_world_cam=T_cam_world.inverse(), depth=depth
        )
        sigma_px = self._config.front_end.patch_sigma_px
        note = KeyframeNote(
            keyframe_id=self._new_keyframe_id(),
            t_ns=t_ns,
            grey=grey,
            T_cam_world=T_cam_world,
            twist=self._motion.twist,
            ids=np.concatenate([self._poses.landmarks.ids[found.rows], ids]),
            uv_px=taken,
            sigma_px=np.concatenate(
                [np.full(len(found.rows), sigma_px), np.full(len(ids), 1.3 * sigma_px)]
            ),
            born_ids=born_ids,
            born_uv_px=born_px,
        )
        self._link.send(note)
        self._pending = (note, self._frame_count)
        self._keyframe_frame = self._frame_count
