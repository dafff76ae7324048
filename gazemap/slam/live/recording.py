"""Live tracking of a recording: what a camera would have got, frame by frame."""

from dataclasses import dataclass, replace

import numpy as np

from gazemap.errors import InputError
from gazemap.ports import Progress, Session
from gazemap.slam.live.config import LiveConfig
from gazemap.slam.live.tracker import LiveTracker
from gazemap.types.map import MapEvent, MapEventKind
from gazemap.types.tracking import Scale, Tracked, TrackingOutcome, Trajectory

# Four frames are 0.13 s at 30 a second: what mapping takes when it has a core.
_LAG_FRAMES = 4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LiveResult:
    """What live tracking said while it ran.

    Attributes:
        trajectory: the poses as they were told, of the map that was tracked at the end.
        frame_count: frames that were looked at.
        events: what happened to the map.
        point_count: points of the map at the end.
    """

    trajectory: Trajectory
    frame_count: int
    events: tuple[MapEvent, ...]
    point_count: int


class _Told:
    """The poses that were told, as rows of one block.

    A record a frame, among arrays that come and go, would leave the memory of a long recording in
    shreds.
    """

    def __init__(self, frame_count: int) -> None:
        """Make room for all frames of a recording."""
        self._t_ns = np.zeros(frame_count, dtype=np.int64)
        self._map_id = np.full(frame_count, -1, dtype=np.int64)
        self._quat_xyzw = np.zeros((frame_count, 4))
        self._p_world_cam = np.zeros((frame_count, 3))
        self.count = 0

    def add(self, outcome: TrackingOutcome) -> None:
        """Take the outcome of the next frame."""
        i, self.count = self.count, self.count + 1
        if isinstance(outcome, Tracked):
            self._t_ns[i], self._map_id[i] = outcome.t_ns, outcome.map_id
            self._quat_xyzw[i] = outcome.T_world_cam.quat_xyzw
            self._p_world_cam[i] = outcome.T_world_cam.t

    def path(self, *, map_id: int, first_ns: int, scale: Scale) -> Trajectory:
        """Return the poses in one map from a time on."""
        rows = np.flatnonzero((self._map_id == map_id) & (self._t_ns >= first_ns))
        return Trajectory(
            t_ns=self._t_ns[rows],
            quat_xyzw=self._quat_xyzw[rows],
            p_world_cam=self._p_world_cam[rows],
            scale=scale,
            map_id=map_id,
        )


def track_recording(
    session: Session,
    config: LiveConfig,
    *,
    use_tags: bool,
    rng: np.random.Generator,
    progress: Progress,
) -> LiveResult:
    """Track a recording as if it were live.

    Mapping is waited for as long after a keyframe as it may take live, so that the same recording
    gives the same poses. Poses that were told in another world, before the tags set it or in
    another map, are in no trajectory together with the last ones and are left out.

    Args:
        session: the recording.
        config: settings; `lag_frames` is set where it is None.
        use_tags: whether the recording's tags set the world.
        rng: samples the hypotheses of a start.
        progress: told of every frame.

    Raises:
        InputError: if no frame could be tracked.
    """
    if config.lag_frames is None:
        config = replace(config, lag_frames=_LAG_FRAMES)
    layout = session.data.tags if use_tags else None
    total = len(session.scene_t_ns)
    told = _Told(total)
    events: list[MapEvent] = []
    with LiveTracker(session.scene_camera, layout=layout, config=config, rng=rng) as tracker:
        inertial = iter(session.data.imu or ())
        sample = next(inertial, None)
        for frame in session.scene_frames():
            while sample is not None and sample.t_ns <= frame.t_ns:
                tracker.inertial(sample)
                sample = next(inertial, None)
            told.add(tracker.track(frame))
            events.extend(tracker.take_events())
            progress("tracking", told.count, total)
        map_id, scale = tracker.map_id, tracker.scale
        point_count = len(tracker.points_world())
    anchored = [e.t_ns for e in events if e.kind is MapEventKind.RE_ANCHORED and e.map_id == map_id]
    path = told.path(map_id=map_id, first_ns=max(anchored, default=0), scale=scale)
    if len(path) == 0:
        raise InputError(
            "no frame could be tracked", where=session.data.name, todo="move the head sideways"
        )
    return LiveResult(
        trajectory=path, frame_count=told.count, events=tuple(events), point_count=point_count
    )
