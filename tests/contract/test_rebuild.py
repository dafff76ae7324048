"""A rebuild folder is what INTERFACES promises, whatever the session has and whoever stops it."""

import hashlib
import json
import shutil
import time

import pytest

from services import children
from services.rebuild.run import RebuildConfig, rebuild
from tests.rebuild_contract import assert_rebuild_is_as_promised

# What tells how long something took differs from run to run.
TIMED = ("report.html", "summary.json", ".stages")


def digests(folder, *, leave_out=()):
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.relative_to(folder).parts[0] not in leave_out
    }


def run(session, out):
    rebuild(session, out, RebuildConfig(), progress=lambda *_: None)


@pytest.fixture(scope="module")
def rebuilt(small_session, tmp_path_factory):
    out = tmp_path_factory.mktemp("rebuilt")
    before = digests(small_session.session)
    run(small_session.session, out)
    assert digests(small_session.session) == before
    return out


def test_every_file_is_as_promised(rebuilt):
    assert_rebuild_is_as_promised(rebuilt, scale="metric")


def test_it_goes_on_from_the_stages_that_were_finished_with_the_same_bytes(
    rebuilt, small_session, tmp_path
):
    out = tmp_path / "stopped"
    shutil.copytree(rebuilt / ".stages", out / ".stages")
    for stage in ("fixations", "grounding"):
        shutil.rmtree(out / ".stages" / stage)
    (out / ".stages" / ".99999999.partial-fixations").mkdir()
    run(small_session.session, out)
    assert digests(out, leave_out=TIMED) == digests(rebuilt, leave_out=TIMED)
    assert not list(out.rglob(".*.partial-*"))


@pytest.mark.slow
@pytest.mark.parametrize("after_s", [4.0, 9.0, 15.0])
def test_killed_at_any_time_it_ends_with_the_same_bytes(rebuilt, small_session, tmp_path, after_s):
    arguments = ("rebuild", str(small_session.session), "--out", str(tmp_path / "out"))
    with (tmp_path / "log").open("w") as log:
        killed = children.start(*arguments, stdout=log, stderr=log)
        time.sleep(after_s)
        killed.process.kill()
        killed.stop()
        finished = children.start(*arguments, stdout=log, stderr=log)
        assert finished.process.wait(250) == 0
        finished.stop()
    assert digests(tmp_path / "out", leave_out=TIMED) == digests(rebuilt, leave_out=TIMED)


OPTIONAL = ("gaze.csv", "fixations.csv", "narration.vtt", "blinks.csv", "events.csv", "info.json")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("missing", "scale"),
    [
        (("tags.yaml",), "arbitrary"),
        (("gaze.csv", "fixations.csv"), "metric"),
        (("fixations.csv",), "metric"),
        (("narration.vtt",), "metric"),
        (("overhead.mp4", "overhead_timestamps.csv", "overhead_camera.json"), "metric"),
        ((*OPTIONAL, "tags.yaml", "overhead.mp4"), "arbitrary"),
    ],
    ids=lambda each: each[0] if isinstance(each, tuple) else each,
)
def test_what_is_optional_may_be_missing(small_session, tmp_path, missing, scale):
    session, out = tmp_path / "session", tmp_path / "out"
    shutil.copytree(small_session.session, session)
    for name in missing:
        (session / name).unlink()
    run(session, out)
    assert_rebuild_is_as_promised(out, scale=scale, least_pictures=1)
    if "narration.vtt" in missing:
        assert json.loads((out / "plan.json").read_text())["instructions"] == []
