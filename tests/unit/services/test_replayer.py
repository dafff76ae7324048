import numpy as np
import pytest

from gazemap.errors import ConfigError
from gazemap.session import open_session
from gazemap.types.status import Level, ServiceStatus
from gazemap.wire import images, rig
from gazemap.wire.mapping import encode_status
from services.bus.base import Inbox
from services.bus.keys import Stream
from services.bus.memory import Exchange, MemoryBus
from services.replayer import Pace, ReplayConfig, replay, wait_for_services
from tests.session_writer import SessionWriter


class FakeClock:
    """A clock that jumps to whatever is waited for; it stops a replay after `stop_s`."""

    def __init__(self, stop_s=1e9):
        self.time_s, self.stop_s = 100.0, stop_s
        self.waits = []

    def now_s(self):
        return self.time_s

    def wait_until(self, when_s):
        self.waits.append(when_s)
        self.time_s = max(self.time_s, when_s)
        return self.time_s < self.stop_s


@pytest.fixture
def writer(tmp_path):
    made = SessionWriter(path=tmp_path / "walk")
    made.write_all()
    return made


def published(session, *, clock=None, **changes):
    exchange, inbox = Exchange(), Inbox(frame_limit=1000)
    listener = MemoryBus(exchange)
    for stream in Stream:
        listener.subscribe(stream, inbox)
    report = replay(
        session, MemoryBus(exchange), config=ReplayConfig(**changes), clock=clock or FakeClock()
    )
    messages = []
    while (message := inbox.get(timeout_s=0)) is not None:
        messages.append(message)
    assert report.message_count == len(messages)
    return messages, report


def test_everything_is_published_once_in_the_order_of_time(writer):
    session = open_session(writer.path)
    messages, report = published(session)
    assert report.is_whole
    by_stream = {s: [m.payload for m in messages if m.stream is s] for s in Stream}
    frames = [images.decode_image(p, stream="head/image") for p in by_stream[Stream.HEAD_IMAGE]]
    assert [f.t_ns for f in frames] == writer.frame_t_ns
    gaze = [rig.decode_gaze(p) for p in by_stream[Stream.GAZE]]
    assert [g.t_ns for g in gaze] == session.data.gaze.t_ns.tolist()
    assert [rig.decode_cue(p) for p in by_stream[Stream.NARRATION]] == list(session.data.narration)
    assert len(by_stream[Stream.TAGS]) == len(by_stream[Stream.HEAD_CALIBRATION]) == 1
    assert messages[0].stream is Stream.SESSION


def test_frames_are_close_to_what_was_recorded_and_png_is_equal(writer):
    session = open_session(writer.path)
    recorded = [f.image for f in session.scene_frames()]
    for image_format, most in (("jpeg", 4.0), ("png", 0.0)):
        messages, _ = published(session, image_format=images.ImageFormat(image_format))
        sent = [m.payload for m in messages if m.stream is Stream.HEAD_IMAGE]
        for payload, original in zip(sent, recorded, strict=True):
            got = images.decode_image(payload, stream="head/image").image
            assert np.abs(got.astype(float) - original).mean() <= most


def test_a_cue_is_sent_when_it_has_been_said(writer):
    messages, _ = published(open_session(writer.path))
    order = [
        rig.decode_cue(m.payload).end_ns
        if m.stream is Stream.NARRATION
        else images.decode_image(m.payload, stream="head/image").t_ns
        for m in messages
        if m.stream in (Stream.NARRATION, Stream.HEAD_IMAGE)
    ]
    assert order == sorted(order)


@pytest.mark.parametrize("rate", [0.5, 1.0, 4.0])
def test_the_rate_sets_the_pace(writer, rate):
    session, clock = open_session(writer.path), FakeClock()
    published(session, clock=clock, rate=rate, linger_s=0.0)
    length_s = (session.scene_t_ns[-1] - session.scene_t_ns[0]) / 1e9
    assert clock.time_s - 100.0 == pytest.approx(length_s / rate, abs=1e-6)


def test_a_replay_that_is_stopped_says_so(writer):
    messages, report = published(open_session(writer.path), clock=FakeClock(stop_s=100.3))
    assert not report.is_whole
    assert 5 < len(messages) < 20


def test_the_end_of_the_recording_is_told_once(writer):
    def ends(session):
        messages, _ = published(session)
        events = [rig.decode_event(m.payload) for m in messages if m.stream is Stream.EVENT]
        return [e.name for e in events]

    assert ends(open_session(writer.path)) == ["recording.end"]
    writer.text("events.csv", f"timestamp [ns],name\n{writer.frame_t_ns[-1]},recording.end\n")
    assert ends(open_session(writer.path)) == ["recording.end"]


def test_services_are_waited_for():
    exchange, clock = Exchange(), FakeClock()
    config = ReplayConfig(wait_for=("mapping",), wait_s=5)
    bus = MemoryBus(exchange)
    assert wait_for_services(bus, config=config, clock=clock) == {"mapping"}
    assert 105 < clock.time_s < 106
    MemoryBus(exchange).announce("mapping")
    assert wait_for_services(bus, config=config, clock=clock) == frozenset()


class TalkingClock(FakeClock):
    """A clock that lets a second pass whenever it is asked, and a service say something."""

    def __init__(self, bus, payloads):
        super().__init__()
        self.bus, self.payloads = bus, payloads

    def now_s(self):
        self.time_s += 1.0
        self.bus.publish(Stream.MAPPING_STATUS, self.payloads[int(self.time_s) % 2])
        return super().now_s()


def status_at(t_ns):
    return encode_status(ServiceStatus(service="mapping", t_ns=t_ns, level=Level.OK))


@pytest.mark.parametrize("alien", [b"\xff no protobuf", status_at(0)])
@pytest.mark.parametrize("told", [status_at(2**62), status_at(5)])
def test_a_service_that_talks_but_does_not_get_on_holds_up_no_replay(writer, alien, told):
    bus = MemoryBus(Exchange())
    clock = TalkingClock(bus, (alien, told))
    report = replay(
        open_session(writer.path), bus, config=ReplayConfig(max_lead_s=0.5), clock=clock
    )
    assert report.is_whole


def test_a_service_that_was_started_anew_is_sent_what_it_needs_to_begin():
    bus, clock = MemoryBus(Exchange()), FakeClock()
    pace = Pace(bus, max_lead_s=0.1)
    pace.hold_back(10**9, clock)
    for told in (10**9, 0):
        bus.publish(Stream.MAPPING_STATUS, status_at(told))
    pace.hold_back(2 * 10**9, clock)
    assert clock.time_s == 100.0


def test_what_a_service_said_of_the_session_before_is_no_progress():
    exchange, clock = Exchange(), FakeClock()
    MemoryBus(exchange).publish(Stream.MAPPING_STATUS, status_at(2**62))
    pace = Pace(MemoryBus(exchange), max_lead_s=0.1)
    pace.hold_back(10**9, clock)
    clock.stop_s = 0.0
    before = len(clock.waits)
    pace.hold_back(2 * 10**9, clock)
    assert len(clock.waits) > before


@pytest.mark.parametrize("changes", [{"rate": 0.0}, {"jpeg_quality": 0}])
def test_a_setting_out_of_range_is_refused(changes):
    with pytest.raises(ConfigError):
        ReplayConfig(**changes)
