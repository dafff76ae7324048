"""`gazemap replay` over a real router: what a rig sends arrives at another process."""

import subprocess
import time

import pytest

from gazemap.session import open_session
from gazemap.wire import images
from services import children
from services.bus.base import Inbox
from services.bus.keys import Stream
from services.bus.zenoh import ZenohBus, ZenohConfig
from tests.ports import free_port
from tests.session_writer import SessionWriter

pytestmark = pytest.mark.bus


def command(*arguments):
    return children.start(*map(str, arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def ended(child, timeout_s):
    """Return the exit code of a command, what it printed and what it complained of."""
    try:
        out, err = child.process.communicate(timeout=timeout_s)
    finally:
        child.stop()
    return child.process.returncode, out, err


@pytest.fixture
def endpoint():
    where = f"tcp/127.0.0.1:{free_port()}"
    router = command("router", "--listen", where)
    assert router.process.stderr.readline().strip() == "router ready"
    yield where
    router.stop()
    router.process.communicate(timeout=10)


def test_a_recording_arrives_whole_and_in_order(tmp_path, endpoint):
    writer = SessionWriter(path=tmp_path / "walk")
    writer.write_all()
    config = tmp_path / "replay.toml"
    config.write_text(
        f'wait_for = ["listener"]\nlinger_s = 1.5\n[bus]\nendpoint = "{endpoint}"\nrig = "r2"\n'
    )
    inbox = Inbox(frame_limit=1000)
    with ZenohBus(ZenohConfig(rig="r2", endpoint=endpoint, connect_timeout_s=10)) as bus:
        for stream in (Stream.HEAD_IMAGE, Stream.GAZE, Stream.NARRATION, Stream.EVENT, Stream.TAGS):
            bus.subscribe(stream, inbox)
        bus.announce("listener")
        replay = command("replay", writer.path, "--config", config)
        got = []
        deadline = time.monotonic() + 60
        while not any(m.stream is Stream.EVENT for m in got) and time.monotonic() < deadline:
            message = inbox.get(timeout_s=0.2)
            got += [] if message is None else [message]
        code, out, err = ended(replay, 30)
    assert code == 0, err
    assert "messages, at most" in out
    counts = {s: sum(m.stream is s for m in got) for s in Stream}
    session = open_session(writer.path)
    assert counts[Stream.GAZE] == len(session.data.gaze.t_ns)
    assert counts[Stream.NARRATION] == 2
    assert counts[Stream.TAGS] == 1
    frames = [
        images.decode_image(m.payload, stream="i") for m in got if m.stream is Stream.HEAD_IMAGE
    ]
    assert [f.t_ns for f in frames] == writer.frame_t_ns


def test_without_a_router_it_says_so(tmp_path):
    writer = SessionWriter(path=tmp_path / "walk")
    writer.write_all()
    config = tmp_path / "replay.toml"
    config.write_text(f'[bus]\nendpoint = "tcp/127.0.0.1:{free_port()}"\nconnect_timeout_s = 0.5\n')
    replay = command("replay", writer.path, "--config", config)
    code, _, err = ended(replay, 60)
    assert code == 1
    assert "no router reached" in err
    assert err.count("\n") == 1
