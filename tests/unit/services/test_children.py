"""Processes end when they are asked to, and with the process that started them."""

import os
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from services import children
from tests.ports import free_port

ROOT = Path(__file__).resolve().parents[3]
PARENT = """
import subprocess, sys, time
from services import children
log = open(sys.argv[1], "w")
child = children.start(*sys.argv[2:], stdout=log, stderr=log)
print(child.process.pid, flush=True)
time.sleep(60)
"""


def ends_within(pid_fd, timeout_s):
    """Whether the process of a pidfd ends in time."""
    return bool(select.select([pid_fd], [], [], timeout_s)[0])


def wait_for_line(path, timeout_s=20):
    deadline = time.monotonic() + timeout_s
    while not path.read_text() and time.monotonic() < deadline:
        time.sleep(0.05)
    return path.read_text()


def test_a_child_ends_with_a_parent_that_was_killed(tmp_path):
    log = tmp_path / "log"
    router = ["router", "--listen", f"tcp/127.0.0.1:{free_port()}"]
    parent = subprocess.Popen(
        [sys.executable, "-c", PARENT, str(log), *router],
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
    )
    child = os.pidfd_open(int(parent.stdout.readline()))
    assert wait_for_line(log) == "router ready\n"
    parent.kill()
    parent.communicate(timeout=10)
    assert ends_within(child, 10)


@pytest.mark.parametrize(
    ("command", "number"),
    [(("serve", "grounding"), signal.SIGTERM), (("serve", "mapping"), signal.SIGINT)],
)
def test_a_service_that_waits_for_its_router_says_so_and_can_be_stopped(tmp_path, command, number):
    log = tmp_path / "log"
    with log.open("w") as file:
        child = children.start(
            *command, "--connect", f"tcp/127.0.0.1:{free_port()}", stdout=file, stderr=file
        )
    try:
        assert "no router reached; start `gazemap router`" in wait_for_line(log)
        child.process.send_signal(number)
        assert child.process.wait(10) == 0
    finally:
        child.stop()
    assert len(log.read_text().splitlines()) == 1
