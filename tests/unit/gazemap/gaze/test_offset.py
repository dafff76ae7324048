from dataclasses import replace

import numpy as np
import pytest

from gazemap.gaze.config import OffsetConfig
from gazemap.gaze.directions import angles_of, directions_of
from gazemap.gaze.offset import estimate_gaze_offset
from gazemap.geometry.pose import Pose
from gazemap.types.scene import ObjectState, SceneObject
from gazemap.types.session import Fixation

CENTRES = np.array([[-0.2, 0.1, 0.02], [0.1, 0.12, 0.02], [0.0, -0.1, 0.02], [0.22, -0.05, 0.02]])


def things() -> tuple[SceneObject, ...]:
    return tuple(
        SceneObject(
            object_id=f"object-{k + 1}",
            size_m=np.full(3, 0.04),
            track=(
                ObjectState(
                    t_ns=0,
                    left_ns=None,
                    T_world_body=Pose(R=np.eye(3), t=centre),
                    cov_world=1e-6 * np.eye(3),
                ),
            ),
            mean_bgr=np.zeros(3),
        )
        for k, centre in enumerate(CENTRES)
    )


def looks(camera, trajectory, *, offset_deg, seed=2, count=40) -> tuple[Fixation, ...]:
    """Return fixations of which two thirds are on things and the rest anywhere."""
    rng = np.random.default_rng(seed)
    found = []
    for k in range(count):
        t_ns = int((0.2 + 5.4 * k / count) * 1e9)
        target = CENTRES[rng.integers(4)] + rng.normal(0, 0.004, 3)
        if rng.random() < 0.33:
            target = np.array([*rng.uniform(-0.3, 0.3, 2), 0.0])
        seen = angles_of(trajectory.at(t_ns).inverse().transform(target[None]))
        u_px, v_px = camera.project(directions_of(seen + np.radians(offset_deg)))[0]
        found.append(
            Fixation(
                fixation_id=k + 1,
                start_ns=t_ns - 10,
                end_ns=t_ns + 10,
                u_px=float(u_px),
                v_px=float(v_px),
            )
        )
    return tuple(found)


@pytest.mark.parametrize("offset_deg", [(0.8, -0.3), (-1.5, 2.0), (2.5, 1.0)])
def test_the_offset_is_found_within_its_uncertainty(camera, trajectory, offset_deg):
    given = looks(camera, trajectory, offset_deg=np.array(offset_deg))
    got = estimate_gaze_offset(
        given, trajectory=trajectory, camera=camera, objects=things(), config=OffsetConfig()
    )
    error = np.degrees([got.azimuth_rad, got.elevation_rad]) - offset_deg
    sigma = np.degrees([got.azimuth_sigma_rad, got.elevation_sigma_rad])
    assert got.is_applied
    assert (np.abs(error) < 0.25).all()
    assert (np.abs(error) < 3 * sigma).all()
    assert (sigma < 0.25).all()


def test_many_looks_at_a_place_that_is_not_known_exactly_do_not_bend_the_offset(camera, trajectory):
    """A stack's height that is off by 25 mm moves what is looked at there by two degrees."""
    given = list(looks(camera, trajectory, offset_deg=np.array([0.5, 0.5])))
    wrong = CENTRES[2] + [0.0, 0.0, 0.025]
    for k in range(0, 40, 2):
        t_ns = given[k].mid_ns
        seen = angles_of(trajectory.at(t_ns).inverse().transform(wrong[None]))
        u_px, v_px = camera.project(directions_of(seen + np.radians([0.5, 0.5])))[0]
        given[k] = replace(given[k], u_px=float(u_px), v_px=float(v_px))
    got = estimate_gaze_offset(
        tuple(given), trajectory=trajectory, camera=camera, objects=things(), config=OffsetConfig()
    )
    error = np.degrees([got.azimuth_rad, got.elevation_rad]) - 0.5
    sigma = np.degrees([got.azimuth_sigma_rad, got.elevation_sigma_rad])
    assert (np.abs(error) < 3 * sigma).all()
    assert (sigma < 0.6).all()


def test_a_small_offset_is_not_applied(camera, trajectory):
    given = looks(camera, trajectory, offset_deg=np.array([0.05, 0.0]))
    got = estimate_gaze_offset(
        given, trajectory=trajectory, camera=camera, objects=things(), config=OffsetConfig()
    )
    assert not got.is_applied


def test_without_objects_the_uncertainty_is_the_usual_one(camera, trajectory):
    given = looks(camera, trajectory, offset_deg=np.array([1.0, 0.0]))
    got = estimate_gaze_offset(
        given, trajectory=trajectory, camera=camera, objects=(), config=OffsetConfig()
    )
    assert not got.is_applied
    assert got.azimuth_sigma_rad == pytest.approx(np.radians(1.0))


def test_looks_at_where_something_was_put_unseen_do_not_draw_the_offset(camera, trajectory):
    """One thing is taken after two seconds and put on another, where it was not recognised."""
    true_deg = np.array([0.5, 0.5])
    given = list(looks(camera, trajectory, offset_deg=true_deg))
    on_top = CENTRES[2] + [0.0, 0.0, 0.045]
    late = [k for k, f in enumerate(given) if f.mid_ns > 2_000_000_000]
    for k in late:
        t_ns = given[k].mid_ns
        seen = angles_of(trajectory.at(t_ns).inverse().transform(on_top[None]))
        u_px, v_px = camera.project(directions_of(seen + np.radians(true_deg)))[0]
        given[k] = replace(given[k], u_px=float(u_px), v_px=float(v_px))
    first, *others = things()
    taken = replace(first, track=(replace(first.track[0], left_ns=2_000_000_000),))
    got = estimate_gaze_offset(
        tuple(given),
        trajectory=trajectory,
        camera=camera,
        objects=(taken, *others),
        config=OffsetConfig(),
    )
    error = np.degrees([got.azimuth_rad, got.elevation_rad]) - true_deg
    assert np.linalg.norm(error) < 0.4
