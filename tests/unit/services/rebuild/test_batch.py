"""Several sessions: where each goes, and what an interruption leaves behind."""

import time

import pytest

from gazemap.errors import InputError
from services.rebuild.batch import jobs_of, rebuild_many
from tests.session_writer import SessionWriter


def test_sessions_of_one_name_are_told_apart_by_their_parents(tmp_path):
    sessions = [tmp_path / "a" / "session", tmp_path / "b" / "session", tmp_path / "c" / "walk"]
    names = [job.out.name for job in jobs_of(sessions, tmp_path / "out")]
    assert names == ["a-session", "b-session", "walk"]


def test_a_session_given_twice_is_refused(tmp_path):
    with pytest.raises(InputError, match="two sessions would go to"):
        jobs_of([tmp_path / "walk", tmp_path / "walk"], tmp_path / "out")


def test_a_batch_that_is_interrupted_ends_what_runs_and_begins_no_more(tmp_path):
    sessions = []
    for name in ("a", "b", "c"):
        writer = SessionWriter(path=tmp_path / name)
        writer.write_all()
        sessions.append(writer.path)
    (sessions[0] / "scene.mp4").unlink()
    lines = rebuild_many(sessions, tmp_path / "out", options={}, jobs=1)
    assert "scene.mp4" in next(lines)
    began_s = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        lines.throw(KeyboardInterrupt())
    assert time.monotonic() - began_s < 15
    assert not (tmp_path / "out").exists()
