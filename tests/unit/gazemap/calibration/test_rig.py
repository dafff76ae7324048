import json
from pathlib import Path

import numpy as np
import pytest

from gazemap.calibration import load_rig
from gazemap.errors import ConfigError, InputError
from gazemap.sim.config import Level, preset
from gazemap.sim.sensors import build_camera

RIG = """
name = "bench"
date = "2026-01-02"
tags = "tags.yaml"
[head_camera]
file = "head.json"
width_px = 800
height_px = 600
"""
TAGS = """family: tag36h11
frame: world
tags:
  - {id: 3, size: 0.06, position: [0.1, 0.2, 0], orientation: [0, 0, 0, 1]}
"""
HEAD = {
    "camera_matrix": [[560, 0, 401], [0, 559, 298], [0, 0, 1]],
    "distortion_coefficients": [0.1, 0, 0, 0],
    "readout_s": 0.012,
}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "rig.toml").write_text(RIG)
    (tmp_path / "tags.yaml").write_text(TAGS)
    (tmp_path / "head.json").write_text(json.dumps(HEAD))
    return tmp_path


def test_a_rig_has_its_cameras_and_tags(folder):
    rig = load_rig(folder)
    assert rig.name == "bench"
    assert rig.head_camera.K[0, 2] == 401
    assert rig.head_camera.readout_s == 0.012
    assert rig.overhead_camera is None
    assert [tag.tag_id for tag in rig.layout.tags] == [3]


def test_a_missing_file_is_named(folder):
    (folder / "head.json").unlink()
    with pytest.raises(InputError, match=r"head\.json"):
        load_rig(folder)


def test_a_folder_without_a_description_is_refused(tmp_path):
    with pytest.raises(ConfigError, match=r"rig\.toml: cannot be read"):
        load_rig(tmp_path)


def test_the_demo_rig_is_the_simulators():
    folder = Path(__file__).resolve().parents[4] / "calib" / "demo" / "2026-11-23"
    rig = load_rig(folder)
    config = preset(Level.EASY)
    for ours, lens in (
        (rig.head_camera, config.scene_lens),
        (rig.overhead_camera, config.overhead_lens),
    ):
        theirs = build_camera(lens)
        np.testing.assert_allclose(ours.K, theirs.K)
        np.testing.assert_allclose(ours.distortion, theirs.distortion)
        assert (ours.width_px, ours.height_px) == (theirs.width_px, theirs.height_px)
    assert [tag.tag_id for tag in rig.layout.tags] == list(range(6))
