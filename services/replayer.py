"""Publishes a recording as a rig would: every message at its time."""

import logging
import time
from collections.abc import Iterator
from dataclasses import dataclass, field

from gazemap.errors import ConfigError, InputError
from gazemap.ports import Progress
from gazemap.session.frames import FrameSource, ImageFiles
from gazemap.session.mcap_frames import McapImages
from gazemap.session.recorded import RecordedSession
from gazemap.session.records import Record, coded_frame_records, record_of, records
from gazemap.types.session import Event
from gazemap.wire import images, rig
from gazemap.wire.images import ImageFormat
from gazemap.wire.mapping import decode_status
from gazemap.wire.streams import Stream
from services.bus.base import Bus, Inbox, Message
from services.bus.zenoh import ZenohConfig
from services.clock import Clock

RECORDING_END = "recording.end"
_POLL_S = 0.2
_MS = 1_000_000
_PACE_POLL_S = 0.05
# A service that says nothing for so long is not waited for.
_SILENCE_S = 20.0
# Nor one that speaks but does not get on; it takes a while to begin.
_STANDSTILL_S = 120.0
_HISTORY_S = 0.5
_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayConfig:
    """How a recording is published.

    Attributes:
        bus: how to reach the router.
        rate: how much faster than it was recorded.
        image_format: how frames of a video are compressed anew; images are sent as they are.
        jpeg_quality: 1 to 100.
        wait_for: services that must live before the first message.
        wait_s: how long to wait for them.
        linger_s: how long to stay on the bus after the last message, for who missed one.
        max_lead_s: how far the recording may run ahead of the mapping service; None lets it run,
            as a rig would, and a service that is too slow skips images.
    """

    bus: ZenohConfig = field(default_factory=lambda: ZenohConfig(connect_timeout_s=30.0))
    rate: float = 1.0
    image_format: ImageFormat = ImageFormat.JPEG
    jpeg_quality: int = 95
    wait_for: tuple[str, ...] = ()
    wait_s: float = 60.0
    linger_s: float = 2.0
    max_lead_s: float | None = None

    def __post_init__(self) -> None:
        """Check what no type does."""
        if not self.rate > 0:
            raise ConfigError(f"rate: a positive number expected, got {self.rate}")
        if self.image_format is ImageFormat.OTHER or not 1 <= self.jpeg_quality <= 100:
            raise ConfigError("image_format is jpeg or png, jpeg_quality 1 to 100")


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayReport:
    """What was published.

    Attributes:
        message_count: how many messages.
        worst_delay_s: how late the latest of them was.
        is_whole: whether the recording was published to its end.
    """

    message_count: int
    worst_delay_s: float
    is_whole: bool


def replay(
    session: RecordedSession,
    bus: Bus,
    *,
    config: ReplayConfig,
    clock: Clock,
    progress: Progress | None = None,
) -> ReplayReport:
    """Publish a recording; a message whose time has passed is sent at once, none is left out."""
    count, worst_delay_s = 0, 0.0
    last_ns = max([0, *session.scene_t_ns[-1:]])
    start_ns: int | None = None
    pace = Pace(bus, max_lead_s=config.max_lead_s)
    start_s = clock.now_s()
    for record in live_records(session, config):
        start_ns = record.log_ns if start_ns is None else start_ns
        start_s += pace.hold_back(record.log_ns, clock)
        due_s = start_s + (record.log_ns - start_ns) / 1e9 / config.rate
        if not clock.wait_until(due_s):
            return ReplayReport(message_count=count, worst_delay_s=worst_delay_s, is_whole=False)
        bus.publish(record.stream, record.payload)
        worst_delay_s = max(worst_delay_s, clock.now_s() - due_s)
        count += 1
        if progress is not None and record.stream is Stream.HEAD_IMAGE:
            progress(
                "publishing (ms)", (record.log_ns - start_ns) // _MS, (last_ns - start_ns) // _MS
            )
    clock.wait_until(clock.now_s() + config.linger_s)
    return ReplayReport(message_count=count, worst_delay_s=worst_delay_s, is_whole=True)


class Pace:
    """Holds a replay back while the mapping service is too far behind."""

    def __init__(self, bus: Bus, *, max_lead_s: float | None) -> None:
        """Follow how far the service has come, where that matters."""
        self._max_lead_s = max_lead_s
        self._inbox = Inbox()
        self._reached_ns: int | None = None
        self._told_ns = 0
        if max_lead_s is not None:
            bus.subscribe(Stream.MAPPING_STATUS, self._inbox)
            self._pass_over_history()

    def _pass_over_history(self) -> None:
        """Leave out what the service said of the session before: it is told to who comes late."""
        end_s = time.monotonic() + _HISTORY_S
        while time.monotonic() < end_s:
            self._inbox.get(timeout_s=_PACE_POLL_S)

    def hold_back(self, t_ns: int, clock: Clock) -> float:
        """Wait until a message of this time may be sent; return how long that took in seconds."""
        if self._max_lead_s is None:
            return 0.0
        if self._reached_ns is None:
            self._reached_ns = t_ns
        began_s = heard_s = moved_s = clock.now_s()
        while t_ns - self._reached_ns > self._max_lead_s * 1e9:
            message = self._inbox.get(timeout_s=_PACE_POLL_S)
            if message is not None:
                heard_s = clock.now_s()
                told_ns = _told_ns(message, before_ns=self._told_ns)
                if told_ns < self._told_ns:
                    # It was started anew and has lost what it was sent: it needs more to begin.
                    self._reached_ns = t_ns
                self._told_ns = told_ns
                moved_s = heard_s if told_ns > self._reached_ns else moved_s
                self._reached_ns = max(self._reached_ns, told_ns)
            now_s = clock.now_s()
            if now_s - heard_s > _SILENCE_S or now_s - moved_s > _STANDSTILL_S:
                self._reached_ns = t_ns
            if not clock.wait_until(now_s):
                break
        return clock.now_s() - began_s


def _told_ns(message: Message, *, before_ns: int) -> int:
    """Return how far the service says it has come; as before, in a message that is none of its."""
    try:
        return decode_status(message.payload, stream=message.stream).t_ns
    except InputError as error:
        _log.warning("%s", error)
        return before_ns


def wait_for_services(bus: Bus, *, config: ReplayConfig, clock: Clock) -> frozenset[str]:
    """Wait until the services live that are to be waited for; return those that do not."""
    deadline_s = clock.now_s() + config.wait_s
    while missing := frozenset(config.wait_for) - bus.alive():
        if clock.now_s() > deadline_s or not clock.wait_until(clock.now_s() + _POLL_S):
            break
    return missing


def live_records(session: RecordedSession, config: ReplayConfig) -> Iterator[Record]:
    """Yield what a rig would send, frames as single images; the last says that it ends.

    A video's packets would be useless after one that was dropped.
    """

    def frame_records(source: FrameSource, stream: Stream, frame_id: str) -> Iterator[Record]:
        if isinstance(source, ImageFiles | McapImages):
            return coded_frame_records(source, stream, frame_id)
        return (
            record_of(
                stream,
                frame.t_ns,
                images.encode_image(
                    frame,
                    frame_id=frame_id,
                    image_format=config.image_format,
                    jpeg_quality=config.jpeg_quality,
                ),
            )
            for frame in source.frames()
        )

    last_ns = 0
    for record in records(session, frame_records=frame_records):
        last_ns = record.log_ns
        yield record
    if not any(event.name == RECORDING_END for event in session.data.events):
        end = rig.encode_event(Event(t_ns=last_ns, name=RECORDING_END))
        yield record_of(Stream.EVENT, last_ns, end)
