"""Live tracking of a recording: what a camera would have got, frame by frame."""

from dataclasses import dataclass, replace

import numpy as np

from gazemap.errors import InputError
from gazemap.ports import Progress, Session
from gazemap.slam.live.config import LiveConfig
from gazemap.slam.live.tracker import LiveTracker
from gazemap.types.map import MapEvent, MapEventKind
from gazemap.types.tracking import Tracked, TrackingOutcome, Trajectory

# Four frames are 0.13 s at 30 a second: what mapping takes when it has a core.
_LAG_FRAMES = 4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LiveResult:
    """What live tracking said while it ran.

    Attributes:
        trajectory: the poses as they were told, of the map that was tracked at the end.
        outcomes: one for each frame.
        events: what happened to the map.
        point_count: points of the map at the end.
    """

    trajectory: Trajectory
    outcomes: tuple[TrackingOutcome, ...]
    events: tuple[MapEvent, ...]
    point_count: int


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
    outcomes: list[TrackingOutcome] = []
    events: list[MapEvent] = []
    total = len(session.scene_t_ns)
    with LiveTracker(session.scene_camera, layout=layout, config=config, rng=rng) as tracker:
        for frame in session.scene_frames():
            outcomes.append(tracker.track(frame))
            events.extend(tracker.take_events())
            progress("tracking", len(outcomes), total)
        map_id, scale = tracker.map_id, tracker.scale
        point_count = len(tracker.points_world())
    told = _in_last_world(outcomes, events, map_id)
    if not told:
        raise InputError(
            "no frame could be tracked", where=session.data.name, todo="move the head sideways"
        )
    return LiveResult(
        trajectory=Trajectory.from_outcomes(told, scale=scale),
        outcomes=tuple(outcomes),
        events=tuple(events),
        point_count=point_count,
    )


def _in_last_world(
    outcomes: list[TrackingOutcome], events: list[MapEvent], map_id: int
) -> list[Tracked]:
    anchored = [e.t_ns for e in events if e.kind is MapEventKind.RE_ANCHORED and e.map_id == map_id]
    first_ns = max(anchored, default=0)
    return [
        o for o in outcomes if isinstance(o, Tracked) and o.map_id == map_id and o.t_ns >= first_ns
    ]
