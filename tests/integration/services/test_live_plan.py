"""Both services, a router and a replay as processes of their own; a robot that knows the schema."""

import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from gazemap.errors import GazemapError
from services.processes import ServiceProcesses
from services.rebuild.run import RebuildConfig, rebuild
from tests.ports import free_port

ROOT = Path(__file__).resolve().parents[3]
SHARED = ROOT / ".." / "shared"
EASY = SHARED / "data" / "sessions" / "easy"
WAIT_S = 280


def live_plan(session, folder):
    """Return the last plan that the robot of docs/examples is told, and all revisions before it."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    wait_for = folder / "replay.toml"
    wait_for.write_text('wait_for = ["mapping", "grounding"]\nwait_s = 120.0\n')
    with ServiceProcesses(folder / "logs") as processes:
        processes.start("router", "router", "--listen", endpoint)
        processes.start("mapping", "serve", "mapping", "--connect", endpoint)
        processes.start("grounding", "serve", "grounding", "--connect", endpoint)
        robot = subprocess.Popen(
            [sys.executable, "docs/examples/robot_client.py", endpoint],
            cwd=ROOT,
            env={"PYTHONPATH": str(ROOT)},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        replay = ("--connect", endpoint, "--max-lead-s", "0.5", "--config", str(wait_for))
        processes.start("replay", "replay", str(session), *replay)
        try:
            said, complaint = robot.communicate(timeout=WAIT_S)
        except subprocess.TimeoutExpired:
            robot.kill()
            robot.communicate()
            processes.check()
            raise
        assert robot.returncode == 0, complaint
        processes.check()
    return [json.loads(line) for line in said.splitlines()]


def grounded_share(plan, truth):
    """Return the share of true instructions that are grounded within 25 mm in the right words."""
    good = 0
    for want, got in zip(truth["plan"], plan["instructions"], strict=True):
        key = "target_position" if want["action"] == "pick" else "location_position"
        near = (
            got[key] is not None and np.linalg.norm(np.subtract(got[key], want["position"])) < 0.025
        )
        good += got["status"] == "grounded" and got["target"] == want["target"] and bool(near)
    return good / len(truth["plan"])


@pytest.mark.bus
def test_a_robot_is_told_a_plan_that_grows_until_it_is_grounded(small_session, tmp_path):
    plans = live_plan(small_session.session, tmp_path)
    truth = json.loads((small_session.truth / "truth.json").read_text())
    revisions = [plan["revision"] for plan in plans]
    assert revisions == sorted(set(revisions))
    assert revisions[0] == 1
    assert [each["target"] for each in plans[-1]["instructions"]] == [
        each["target"] for each in truth["plan"]
    ]
    assert grounded_share(plans[-1], truth) >= 0.5, json.dumps(plans[-1])


@pytest.mark.bus
@pytest.mark.slow
@pytest.mark.skipif(not EASY.exists(), reason="../shared/data/sessions/easy is not there")
def test_live_on_a_whole_session_is_within_ten_points_of_its_rebuild(tmp_path):
    truth = json.loads((EASY / "truth" / "truth.json").read_text())
    live = grounded_share(live_plan(EASY / "session", tmp_path)[-1], truth)
    rebuilt = rebuild(EASY / "session", tmp_path / "out", RebuildConfig(), progress=lambda *_: None)
    offline = grounded_share(rebuilt.grounded.plan.to_json(), truth)
    assert offline >= 0.9
    assert live >= offline - 0.1


def test_a_service_that_fails_is_named_with_its_last_line(tmp_path):
    with ServiceProcesses(tmp_path) as processes:
        processes.start("router", "router", "--config", "none.json5")
        deadline_s = time.monotonic() + 30
        with pytest.raises(GazemapError, match=r"router ended with code 1: .*none\.json5"):
            wait_for_end(processes, "router", deadline_s)


def wait_for_end(processes, name, deadline_s):
    while not processes.has_ended(name) and time.monotonic() < deadline_s:
        time.sleep(0.05)
