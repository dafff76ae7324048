"""`gazemap import` on the recordings that are shared with the project."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gazemap.session import open_session

ROOT = Path(__file__).resolve().parents[3]
DATA = ROOT.parent / "shared" / "data"


def run_import(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "services.cli", "import", *map(str, arguments)],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )


def source(name):
    if not (DATA / name).exists():
        pytest.skip(f"no shared/data/{name}")
    return DATA / name


def test_a_phones_recording_becomes_a_session(tmp_path):
    done = run_import(source("recordings/neon_native"), tmp_path / "a.mcap", "--format", "neon")
    assert (done.returncode, done.stderr) == (0, "")
    session = open_session(tmp_path / "a.mcap")
    assert len(session.scene_t_ns) == 144
    assert len(session.data.gaze.t_ns) == 2659
    # At rest the sensor feels gravity alone.
    felt_m_s2 = np.linalg.norm(session.data.imu.accel_m_s2, axis=1)
    assert 9.0 < float(np.median(felt_m_s2)) < 10.5
    first = next(iter(session.scene_frames()))
    assert first.image.shape == (1200, 1600, 3)


def test_a_phones_recording_without_video_keeps_its_gaze(tmp_path):
    done = run_import(source("recordings/neon_novideo"), tmp_path / "a.mcap")
    assert done.returncode == 0
    assert "no scene video" in done.stderr
    data = open_session(tmp_path / "a.mcap").data
    assert (len(data.fixations), len(data.blinks), len(data.imu.t_ns)) == (23, 2, 969)


def test_an_export_without_video_is_refused_in_one_line(tmp_path):
    done = run_import(source("recordings/pupil_invisible_export"), tmp_path / "a.mcap")
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1
    assert "scene.mp4" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_session_comes_back_to_the_bit(tmp_path):
    folder = open_session(source("sessions/easy/session"))
    done = run_import(DATA / "sessions/easy/session", tmp_path / "easy.mcap")
    assert (done.returncode, done.stderr) == (0, "")
    file = open_session(tmp_path / "easy.mcap")
    assert file.scene_t_ns == folder.scene_t_ns
    for one, other in zip(folder.overhead_frames(), file.overhead_frames(), strict=True):
        np.testing.assert_array_equal(one.image, other.image)
    assert file.data.fixations == folder.data.fixations
    np.testing.assert_array_equal(file.data.gaze.uv_px, folder.data.gaze.uv_px)
