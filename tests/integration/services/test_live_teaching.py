"""What no word explains is asked about, taught, and known from then on: real processes and bus."""

import subprocess
import sys
import threading
import time

import pytest

from gazemap.wire.streams import Stream
from services.bus.base import Inbox
from services.bus.zenoh import ZenohConfig, connect
from services.processes import ServiceProcesses
from services.wire import grounding as wire
from services.wire import queries
from tests.integration.services.test_live_plan import EASY
from tests.ports import free_port

WAIT_S = 250.0


class Walk:
    """A person at the end of a live session, with what they were asked."""

    def __init__(self, bus, inbox):
        self.bus, self.inbox, self.asked = bus, inbox, []

    def hear(self, until, wait_s):
        deadline_s = time.monotonic() + wait_s
        while not until() and time.monotonic() < deadline_s:
            message = self.inbox.get(timeout_s=0.5)
            if message is not None:
                self.asked.append(wire.decode_question(message.payload))

    def ask(self, stream, payload):
        answer = self.bus.ask(stream, payload, timeout_s=30.0)
        assert answer is not None
        return answer

    def teach(self, word, object_id, group):
        document = {"words": [word], "object": object_id, "group": group}
        lesson = queries.encode_teach_request(document)
        return queries.decode_teach_answer(self.ask(Stream.TEACH, lesson))

    def command(self, *arguments):
        """Run `gazemap` as a person would, beside the services."""
        line = [sys.executable, "-m", "services.cli", *arguments, "--connect", self.endpoint]
        return subprocess.run(line, capture_output=True, text=True, timeout=60, check=False)

    def ground(self, sentence):
        request = queries.encode_ground_request(queries.GroundRequest(sentences=(sentence,)))
        (found,) = queries.decode_ground_answer(self.ask(Stream.GROUND, request))["instructions"]
        return found


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    folder = tmp_path_factory.mktemp("walk")
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    wait_for = folder / "replay.toml"
    wait_for.write_text('wait_for = ["mapping", "grounding"]\nwait_s = 120.0\n')
    with ServiceProcesses(folder / "logs") as processes:
        processes.start("router", "router", "--listen", endpoint)
        processes.start("mapping", "serve", "mapping", "--connect", endpoint)
        processes.start("grounding", "serve", "grounding", "--connect", endpoint)
        bus, inbox = connect(ZenohConfig(endpoint=endpoint), stop=threading.Event()), Inbox()
        with bus:
            bus.subscribe(Stream.QUESTION, inbox)
            replay = ("--connect", endpoint, "--max-lead-s", "0.5", "--config", str(wait_for))
            processes.start("replay", "replay", str(EASY / "session"), *replay)
            one = Walk(bus, inbox)
            one.endpoint = endpoint
            one.log = folder / "logs" / "grounding.log"
            yield one
        processes.check()


def things_asked_about(walk, group):
    return {q.object_id for q in walk.asked if q.text.startswith(f"which {group} ")}


@pytest.mark.bus
@pytest.mark.slow
@pytest.mark.skipif(not EASY.exists(), reason="../shared/data/sessions/easy is not there")
def test_what_no_word_explains_is_asked_taught_and_then_known(walk):
    """Nobody speaks of red things or cells; the blue cell is under a cube in the end."""
    walk.hear(lambda: len(things_asked_about(walk, "shape")) >= 2, WAIT_S)
    assert things_asked_about(walk, "colour") == {"object-2", "object-3", "object-4"}
    assert things_asked_about(walk, "shape") == {"object-2", "object-6"}
    assert {q.instruction_index for q in walk.asked} == {wire.NO_INSTRUCTION}
    assert "question: which colour is this? it is none of: blue, yellow (object-2)" in (
        walk.log.read_text()
    )
    before = walk.ground("pick up the red cube")
    assert (before["status"], before["object"]) == ("unknown-symbol", None)
    assert "'red'" in before["question"]
    assert walk.teach("red", "object-2", "colour")["learnt"]
    # It is no known shape either: only the person can say what the word describes.
    done = walk.command("symbols", "answer", "object-3", "red", "--group", "colour")
    assert (done.returncode, done.stdout) == (0, "learnt: object-3 is red\n")
    refused = walk.command("symbols", "answer", "object-99", "red")
    assert refused.returncode == 1
    assert "'object-99' is not seen" in refused.stderr
    after = walk.ground("pick up the red cube")
    assert (after["status"], after["object"]) == ("grounded", "object-4")
    assert walk.ground("pick up the yellow cube")["object"] == "object-7"
