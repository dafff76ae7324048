"""A recording whose bytes were damaged is read, or refused in one line; nothing else happens."""

import shutil

import numpy as np
import pytest

from gazemap.errors import InputError
from gazemap.session import open_session
from gazemap.session.mcap_write import write_mcap
from tests.session_writer import SessionWriter

DAMAGES = 120
TOKENS = [
    *(
        b",",
        b"\n",
        b"nan",
        b"-1",
        b"1e999",
        b"9" * 30,
        b"\x00",
        b"\xff\xfe",
        b'"',
        b"[[[[",
        b"null",
    ),
    *(b"'", b": ", b"- ", b"!!python/object:x", b"1_000", b"*a", b"\r", b"-->", b"99:99:99.999"),
]


def damaged(content, rng):
    content = bytearray(content)
    for _ in range(rng.integers(1, 4)):
        at = int(rng.integers(len(content) + 1))
        to = int(rng.integers(len(content) + 1))
        kind = rng.integers(4)
        if kind == 0:
            del content[at:]
        elif kind == 1:
            content[at : at + int(rng.integers(7))] = TOKENS[rng.integers(len(TOKENS))]
        elif kind == 2:
            del content[at:to]
        else:
            content[at : at + 1] = bytes([rng.integers(256)])
    return bytes(content)


@pytest.fixture
def whole(tmp_path):
    writer = SessionWriter(path=tmp_path / "walk")
    writer.write_all()
    writer.video("overhead.mp4", count=4)
    writer.times("overhead_timestamps.csv", [writer.start_ns + 50_000_000 * i for i in range(4)])
    writer.text("overhead_camera.json", (writer.path / "scene_camera.json").read_text())
    writer.text("info.json", '{"wearer_heading_rad": 1}')
    write_mcap(open_session(writer.path), tmp_path / "walk.mcap", chunk_bytes=3000)
    return writer.path


def outcome(path):
    """What became of reading everything: "read", or the line that refuses it."""
    try:
        session = open_session(path)
        for _ in session.scene_frames():
            pass
        for _ in session.overhead_frames():
            pass
    except InputError as error:
        return str(error)
    return "read"


@pytest.mark.parametrize("seed", [1, 2])
def test_a_damaged_folder_is_read_or_refused_in_one_line(whole, tmp_path, seed):
    rng = np.random.default_rng(seed)
    lines = []
    for _ in range(DAMAGES):
        copy = tmp_path / "copy"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(whole, copy)
        files = sorted(copy.iterdir())
        file = files[rng.integers(len(files))]
        file.write_bytes(damaged(file.read_bytes(), rng))
        lines.append(outcome(copy))
    assert all("\n" not in line and len(line) < 600 for line in lines)
    assert sum(line != "read" for line in lines) > DAMAGES / 2


def test_a_damaged_file_is_read_or_refused_in_one_line(whole, tmp_path):
    rng = np.random.default_rng(3)
    content = (tmp_path / "walk.mcap").read_bytes()
    lines = []
    for _ in range(DAMAGES):
        copy = tmp_path / "copy.mcap"
        copy.write_bytes(damaged(content, rng))
        lines.append(outcome(copy))
    assert all("\n" not in line for line in lines)
    assert 0 < sum(line != "read" for line in lines) < DAMAGES
    assert whole.exists()
