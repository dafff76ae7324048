"""`gazemap replay` over a real router: what a rig sends arrives at another process."""

import subprocess
import sys
import time
from pathlib import Path

import pytest

from gazemap.session import open_session
from gazemap.wire import images
from services.bus.base import Inbox
from services.bus.keys import Stream
from services.bus.zenoh import ZenohBus, ZenohConfig
from tests.ports import free_port
from tests.session_writer import SessionWriter

ROOT = Path(__file__).resolve().parents[3]
pytestmark = pytest.mark.bus


def command(*arguments, **options):
    return subprocess.Popen(
        [sys.executable, "-m", "services.cli", *map(str, arguments)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


@pytest.fixture
def endpoint():
    where = f"tcp/127.0.0.1:{free_port()}"
    router = command("router", "--listen", where)
    assert router.stderr.readline().strip() == "router ready"
    yield where
    router.terminate()
    router.communicate(timeout=10)


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
        out, err = replay.communicate(timeout=30)
    assert replay.returncode == 0, err
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
    _, err = replay.communicate(timeout=60)
    assert replay.returncode == 1
    assert "no router reached" in err
    assert err.count("\n") == 1
