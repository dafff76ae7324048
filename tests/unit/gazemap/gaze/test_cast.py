import numpy as np
import pytest

from gazemap.gaze.cast import cast_fixations
from gazemap.gaze.config import GazeNoise
from gazemap.gaze.directions import angles_of, directions_of
from gazemap.types.fixation import GazeOffset
from gazemap.types.scene import HitKind, Miss, SurfaceHit
from gazemap.types.session import Fixation


class Table:
    """The plane z = 0, with a step 5 cm up for x > 0.1."""

    def cast(self, *, t_ns, origins_world, directions_world):  # noqa: ARG002 - it never changes
        return [self._one(o, d) for o, d in zip(origins_world, directions_world, strict=True)]

    def _one(self, origin, direction):
        for height, name in ((0.05, "object-1"), (0.0, None)):
            point = origin + (height - origin[2]) / direction[2] * direction
            if direction[2] < 0 and (point[0] > 0.1 or name is None):
                return SurfaceHit(
                    point_world=point,
                    normal_world=np.array([0, 0, 1.0]),
                    object_id=name,
                    sigma_m=0.0005,
                )
        return Miss(reason="up")


def offset(azimuth_deg=0.0, elevation_deg=0.0, *, sigma_deg=0.1, is_applied=True) -> GazeOffset:
    return GazeOffset(
        azimuth_rad=np.radians(azimuth_deg),
        elevation_rad=np.radians(elevation_deg),
        azimuth_sigma_rad=np.radians(sigma_deg),
        elevation_sigma_rad=np.radians(sigma_deg),
        is_applied=is_applied,
    )


def look_at(point, camera, trajectory, *, wrong_deg=(0.0, 0.0)) -> Fixation:
    t_ns = 2_000_000_000
    seen = angles_of(trajectory.at(t_ns).inverse().transform(np.array([point])))
    u_px, v_px = camera.project(directions_of(seen + np.radians(wrong_deg)))[0]
    return Fixation(
        fixation_id=1,
        start_ns=t_ns - 10,
        end_ns=t_ns + 10,
        u_px=float(u_px),
        v_px=float(v_px),
    )


def cast(fixation, camera, trajectory, given):
    return cast_fixations(
        (fixation,),
        trajectory=trajectory,
        camera=camera,
        surface=Table(),
        offset=given,
        noise=GazeNoise(),
    )[0]


def test_a_fixation_is_cast_to_the_point_that_was_looked_at(camera, trajectory):
    point = [-0.1, 0.15, 0.0]
    got = cast(look_at(point, camera, trajectory), camera, trajectory, offset())
    assert got.hit is HitKind.SURFACE
    assert got.point_world == pytest.approx(point, abs=1e-6)


def test_an_applied_offset_is_taken_out(camera, trajectory):
    point, wrong = [-0.1, 0.15, 0.0], (1.0, -0.5)
    fixation = look_at(point, camera, trajectory, wrong_deg=wrong)
    taken = cast(fixation, camera, trajectory, offset(*wrong))
    left = cast(fixation, camera, trajectory, offset(*wrong, is_applied=False))
    assert taken.point_world == pytest.approx(point, abs=1e-6)
    assert np.linalg.norm(left.point_world - point) > 0.01
    assert np.trace(left.cov_world) > 10 * np.trace(taken.cov_world)


def test_uncertainty_is_longest_along_the_ray_over_the_table(camera, trajectory):
    got = cast(look_at([-0.1, 0.3, 0.0], camera, trajectory), camera, trajectory, offset())
    values, vectors = np.linalg.eigh(got.cov_world)
    ray = got.point_world - got.origin_world
    along = np.array([ray[0], ray[1], 0]) / np.linalg.norm(ray[:2])
    assert abs(vectors[:, 2] @ along) > 0.95
    assert values[2] > 1.5 * values[1]


def test_uncertainty_on_the_table_is_that_of_many_noisy_rays(camera, trajectory):
    fixation = look_at([-0.15, 0.1, 0.0], camera, trajectory)
    got = cast(fixation, camera, trajectory, offset(sigma_deg=0.5))
    rng = np.random.default_rng(4)
    seen = angles_of(camera.unproject(np.array([[fixation.u_px, fixation.v_px]])))
    rays = directions_of(seen + np.radians(rng.normal(0, 0.5, (4000, 2))))
    T_world_cam = trajectory.at(fixation.mid_ns)
    directions = T_world_cam.rotate(rays)
    points = T_world_cam.t - T_world_cam.t[2] / directions[:, 2:] * directions
    spread = np.cov(points.T)
    assert got.cov_world[:2, :2] == pytest.approx(spread[:2, :2], rel=0.15, abs=3e-6)


def test_uncertainty_grows_at_the_rim_of_a_thing(camera, trajectory):
    rim = cast(look_at([0.101, 0.1, 0.05], camera, trajectory), camera, trajectory, offset())
    middle = cast(look_at([0.2, 0.1, 0.05], camera, trajectory), camera, trajectory, offset())
    assert rim.hit is middle.hit is HitKind.OBJECT
    assert np.trace(rim.cov_world) > 5 * np.trace(middle.cov_world)


def test_a_fixation_without_a_pose_says_so(camera, trajectory):
    lost = Fixation(fixation_id=1, start_ns=8_000_000_000, end_ns=8_100_000_000, u_px=400, v_px=300)
    got = cast(lost, camera, trajectory, offset())
    assert got.hit is HitKind.NONE
    assert got.point_world is None
    assert "lost" in got.reason
