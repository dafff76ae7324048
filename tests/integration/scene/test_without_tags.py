"""A session that no tag sets: the table, the camera above it and the things on it are found."""

import json
import shutil

import numpy as np
import pytest

from gazemap.geometry.align import fit_similarity
from gazemap.pipeline import MappingConfig, locate_cameras, model_scene
from gazemap.session import open_session
from gazemap.session.tum_file import read_tum
from gazemap.types.tracking import Scale


def silent(stage, done, total):
    """Take a report and do nothing."""


@pytest.fixture(scope="module")
def tagless(small_session, tmp_path_factory):
    """The session without its tags, where its cameras were found, and the similarity to truth."""
    folder = tmp_path_factory.mktemp("tagless") / "session"
    shutil.copytree(small_session.session, folder)
    (folder / "tags.yaml").unlink()
    session = open_session(folder)
    located = locate_cameras(session, MappingConfig(), progress=silent)
    found = located.slam.trajectory
    true = read_tum(small_session.truth / "trajectory.tum")
    at = np.searchsorted(true.t_ns, found.t_ns - 1_000_000)
    S_true_world = fit_similarity(found.p_world_cam, true.p_world_cam[at])
    assert S_true_world is not None
    return session, located, S_true_world


def test_the_table_is_level_and_near_its_size(tagless):
    _, located, S_true_world = tagless
    assert located.slam.trajectory.scale is Scale.ARBITRARY
    assert np.degrees(np.arccos(S_true_world.R[2, 2])) < 0.5
    assert abs(S_true_world.transform(np.zeros(3))[2]) < 0.004
    assert 0.5 < S_true_world.scale < 2.0


def test_the_things_are_where_the_fixed_camera_sees_them(tagless, small_session):
    session, located, S_true_world = tagless
    assert located.T_world_overhead is not None
    scene = model_scene(session, located, MappingConfig(), progress=silent)
    truth = json.loads((small_session.truth / "truth.json").read_text())
    true = np.array([each["start"] for each in truth["objects"]])[:, :3, 3]
    found = np.array(
        [S_true_world.transform(each.track[0].T_world_body.t) for each in scene.objects]
    )
    off_m = np.linalg.norm(found[:, None] - true[None], axis=2).min(axis=0)
    assert np.median(off_m) < 0.006
    assert (off_m < 0.02).mean() >= 0.8
