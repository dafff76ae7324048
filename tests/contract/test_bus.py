"""Every bus keeps the same promises: in memory, and over Zenoh through a real router process."""

import subprocess
import threading
import time

import pytest
import zenoh

from gazemap.errors import InputError
from gazemap.wire.schemas import SCHEMAS
from services import children
from services.bus.base import Inbox, Message
from services.bus.keys import Stream
from services.bus.memory import Exchange, MemoryBus
from services.bus.zenoh import ZenohBus, ZenohConfig, _client_config
from tests.ports import free_port

ROLES = ("rig", "mapping", "grounding", "robot", "operator")


def start_router(*options, endpoint=None):
    endpoint = endpoint or f"tcp/127.0.0.1:{free_port()}"
    router = children.start(
        "router", "--listen", endpoint, *options, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    )
    assert router.process.stderr.readline().strip() == "router ready"
    return router, endpoint


def stop(router):
    router.stop()
    router.process.stderr.close()


@pytest.fixture(scope="module")
def endpoint():
    router, where = start_router()
    yield where
    stop(router)


@pytest.fixture(params=["memory", pytest.param("zenoh", marks=pytest.mark.bus)])
def connect(request):
    opened = []
    exchange = Exchange()

    def connect_one():
        if request.param == "memory":
            bus = MemoryBus(exchange)
        else:
            where = request.getfixturevalue("endpoint")
            config = ZenohConfig(rig=request.node.name[:20], endpoint=where, connect_timeout_s=5)
            bus = ZenohBus(config)
        opened.append(bus)
        return bus

    yield connect_one
    for bus in opened:
        bus.close()


def take(inbox, count, timeout_s=5.0):
    deadline = time.monotonic() + timeout_s
    got = []
    while len(got) < count and time.monotonic() < deadline:
        message = inbox.get(timeout_s=0.2)
        got += [] if message is None else [message]
    return got


def test_messages_arrive_in_order_on_their_stream(connect):
    sender, receiver, inbox = connect(), connect(), Inbox()
    receiver.subscribe(Stream.GAZE, inbox)
    for k in range(50):
        sender.publish(Stream.GAZE, bytes([k]))
    sender.publish(Stream.IMU, b"not subscribed")
    assert take(inbox, 50) == [Message(stream=Stream.GAZE, payload=bytes([k])) for k in range(50)]
    assert inbox.get(timeout_s=0.2) is None


def test_a_late_subscriber_gets_what_was_said_before(connect):
    sender = connect()
    for k in range(5):
        sender.publish(Stream.PLAN, bytes([k]))
    inbox = Inbox()
    connect().subscribe(Stream.PLAN, inbox)
    assert [m.payload for m in take(inbox, 5)] == [bytes([k]) for k in range(5)]


def test_a_question_is_answered_and_an_unanswered_one_is_none(connect):
    server, client = connect(), connect()
    server.answer(Stream.PARSE, lambda asked: asked.upper())
    deadline = time.monotonic() + 5
    answer = None
    while answer is None and time.monotonic() < deadline:
        answer = client.ask(Stream.PARSE, b"pick it", timeout_s=1.0)
    assert answer == b"PICK IT"
    assert client.ask(Stream.TEACH, b"x", timeout_s=0.3) is None


def test_an_answer_that_takes_long_holds_up_no_message(connect):
    server, client, inbox = connect(), connect(), Inbox()
    server.subscribe(Stream.GAZE, inbox)
    is_asked, may_answer = threading.Event(), threading.Event()

    def slowly(asked):
        is_asked.set()
        may_answer.wait(10)
        return asked

    server.answer(Stream.PARSE, slowly)
    answers = []

    def ask():
        while not answers:
            answer = client.ask(Stream.PARSE, b"x", timeout_s=5)
            answers.extend([] if answer is None else [answer])

    asking = threading.Thread(target=ask)
    asking.start()
    assert is_asked.wait(10)
    client.publish(Stream.GAZE, b"meanwhile")
    assert [m.payload for m in take(inbox, 1)] == [b"meanwhile"]
    may_answer.set()
    asking.join(15)
    assert answers == [b"x"]


def test_a_question_whose_answer_fails_is_answered_by_none_and_the_next_is_answered(connect):
    server, client = connect(), connect()

    def answer(asked):
        if asked == b"bad":
            raise InputError("cannot be read", where="parse", todo="ask again")
        return asked

    server.answer(Stream.PARSE, answer)
    wait_until(lambda: client.ask(Stream.PARSE, b"good", timeout_s=1) == b"good")
    assert client.ask(Stream.PARSE, b"bad", timeout_s=1) is None
    assert client.ask(Stream.PARSE, b"good", timeout_s=1) == b"good"


@pytest.mark.bus
def test_nothing_is_lost_when_the_router_dies_and_comes_back():
    router, where = start_router()
    config = ZenohConfig(rig="recovery", endpoint=where, connect_timeout_s=5)
    inbox, count = Inbox(), 120
    try:
        with ZenohBus(config) as sender, ZenohBus(config) as receiver:
            receiver.subscribe(Stream.GAZE, inbox)
            while not take(inbox, 1, timeout_s=0.1):
                sender.publish(Stream.GAZE, bytes([255]))
            for k in range(count):
                if k == 40:
                    router.process.kill()
                    stop(router)
                if k == 80:
                    router, _ = start_router(endpoint=where)
                sender.publish(Stream.GAZE, bytes([k]))
                time.sleep(0.01)
            got = []
            deadline = time.monotonic() + 30
            while len(got) < count and time.monotonic() < deadline:
                got += [m.payload[0] for m in take(inbox, 1) if m.payload[0] != 255]
    finally:
        stop(router)
    assert got == list(range(count))


@pytest.mark.bus
def test_a_message_says_which_schema_it_has(endpoint):
    with zenoh.open(_client_config(ZenohConfig(endpoint=endpoint))) as plain:
        seen = plain.declare_subscriber("gazemap/v1/typed/*")
        with ZenohBus(ZenohConfig(rig="typed", endpoint=endpoint)) as bus:
            bus.publish(Stream.GAZE, b"")
            deadline = time.monotonic() + 5
            while (sample := seen.try_recv()) is None and time.monotonic() < deadline:
                bus.publish(Stream.GAZE, b"")
                time.sleep(0.05)
    assert str(sample.encoding) == "application/protobuf;gazemap.v1.GazeSample"


def test_who_lives_is_seen_until_it_leaves(connect):
    service, watcher = connect(), connect()
    service.announce("mapping")
    wait_until(lambda: watcher.alive() == {"mapping"})
    assert watcher.alive() == {"mapping"}
    service.close()
    wait_until(lambda: watcher.alive() == frozenset())
    assert watcher.alive() == frozenset()


def wait_until(condition, timeout_s=5.0):
    deadline = time.monotonic() + timeout_s
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.05)


def test_an_inbox_skips_the_oldest_images_and_nothing_else():
    inbox = Inbox(frame_limit=2)
    for k in range(5):
        inbox.put(Message(stream=Stream.HEAD_IMAGE, payload=bytes([k])))
        inbox.put(Message(stream=Stream.GAZE, payload=bytes([k])))
    got = take(inbox, 7)
    images = [m.payload for m in got if m.stream is Stream.HEAD_IMAGE]
    gaze = [m.payload for m in got if m.stream is Stream.GAZE]
    assert images == [b"\x03", b"\x04"]
    assert gaze == [bytes([k]) for k in range(5)]
    assert inbox.dropped[Stream.HEAD_IMAGE] == 3


@pytest.mark.bus
def test_with_users_a_robot_cannot_send_what_the_mapping_service_sends(tmp_path):
    users = tmp_path / "users.txt"
    users.write_text("".join(f"{role}:secret-{role}\n" for role in ROLES))
    router, where = start_router("--users", str(users))

    def as_role(role, password=None):
        secret = password or f"secret-{role}"
        return ZenohBus(
            ZenohConfig(endpoint=where, user=role, password=secret, connect_timeout_s=3)
        )

    try:
        with (
            as_role("robot") as robot,
            as_role("mapping") as mapping,
            as_role("grounding") as third,
        ):
            inbox = Inbox()
            third.subscribe(Stream.POSE, inbox)
            mapping.publish(Stream.POSE, b"true")
            assert [m.payload for m in take(inbox, 1)] == [b"true"]
            robot.publish(Stream.POSE, b"forged")
            assert inbox.get(timeout_s=1.5) is None
        with pytest.raises(InputError, match="no router reached"):
            as_role("robot", "guess")
    finally:
        stop(router)


OWNERS = {
    "rig": frozenset(
        {
            *(Stream.SESSION, Stream.TAGS, Stream.HEAD_IMAGE, Stream.HEAD_CALIBRATION),
            *(Stream.OVERHEAD_IMAGE, Stream.OVERHEAD_CALIBRATION, Stream.GAZE, Stream.BLINK),
            *(Stream.DEVICE_FIXATION, Stream.EVENT, Stream.IMU, Stream.NARRATION),
            *(Stream.DEPTH, Stream.OVERHEAD_DEPTH),
        }
    ),
    "mapping": frozenset(
        {
            *(Stream.POSE, Stream.FIXATION, Stream.OBJECT, Stream.MAP_POINTS, Stream.MAP_MESH),
            *(Stream.MAP_EVENT, Stream.OVERHEAD_POSE, Stream.MAPPING_STATUS),
        }
    ),
    "grounding": frozenset(
        {
            *(Stream.PLAN, Stream.INSTRUCTION, Stream.SYMBOLS, Stream.QUESTION),
            Stream.GROUNDING_STATUS,
        }
    ),
    "robot": frozenset(),
}


@pytest.mark.bus
def test_every_role_publishes_its_own_streams_and_no_other(tmp_path):
    users = tmp_path / "users.txt"
    users.write_text("".join(f"{role}:secret-{role}\n" for role in ROLES))
    router, where = start_router("--users", str(users))
    inbox, buses = Inbox(frame_limit=1000), {}
    try:
        for role in ROLES:
            buses[role] = ZenohBus(
                ZenohConfig(endpoint=where, user=role, password=f"secret-{role}")
            )
        for stream in SCHEMAS:
            buses["operator"].subscribe(stream, inbox)
        wanted = {(stream, role.encode()) for role, own in OWNERS.items() for stream in own}
        got = set()
        # Lossy streams are sent again: the first may come before the router knows who listens.
        for _ in range(3):
            for role in OWNERS:
                for stream in SCHEMAS:
                    buses[role].publish(stream, role.encode())
            while (message := inbox.get(timeout_s=1.0)) is not None:
                got.add((message.stream, message.payload))
    finally:
        for bus in buses.values():
            bus.close()
        stop(router)
    assert got == wanted


@pytest.mark.bus
def test_no_router_is_one_line_that_says_what_to_do():
    where = f"tcp/127.0.0.1:{free_port()}"
    with pytest.raises(InputError, match=r"no router reached; start `gazemap router`"):
        ZenohBus(ZenohConfig(endpoint=where, connect_timeout_s=0.5))
