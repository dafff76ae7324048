"""A file or folder is whole or not there, and nothing is left beside it."""

import os
import subprocess
import sys

import pytest

from gazemap.session.atomic import whole_file, whole_folder


def test_a_block_that_fails_leaves_what_was_there(tmp_path):
    (tmp_path / "a.txt").write_text("before")
    with pytest.raises(ZeroDivisionError):
        write_half(tmp_path / "a.txt")
    assert (tmp_path / "a.txt").read_text() == "before"
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def write_half(path):
    with whole_file(path) as partial:
        partial.write_text("half")
        raise ZeroDivisionError


def test_what_a_killed_process_left_is_removed(tmp_path):
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait(20)
    (tmp_path / f".{ended.pid}.partial-a.txt").write_text("half")
    (tmp_path / f".{ended.pid}.partial-map").mkdir()
    living = tmp_path / f".{os.getppid()}.partial-a.txt"
    living.write_text("another process writes this now")
    with whole_file(tmp_path / "a.txt") as partial:
        partial.write_text("whole")
    with whole_folder(tmp_path / "map") as partial:
        (partial / "x").write_text("whole")
    assert sorted(p.name for p in tmp_path.iterdir()) == [living.name, "a.txt", "map"]
