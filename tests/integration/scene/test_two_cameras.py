"""A rig that tracks with one camera and gives gaze on the images of another."""

from dataclasses import replace

import numpy as np
import pytest

from gazemap.errors import InputError
from gazemap.gaze.config import GazeNoise, OffsetConfig
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Pose
from gazemap.live_looks import LiveLooks, RecentPath
from gazemap.pipeline import Located, MappingConfig, OffsetMode, find_looks
from gazemap.scene.cast import SceneCaster
from gazemap.scene.surface import table_mesh
from gazemap.session.gaze_camera import gaze_camera_in, gaze_camera_of
from gazemap.types.scene import HitKind, SceneModel
from gazemap.types.session import Fixation, SessionData
from gazemap.types.slam import SlamResult
from gazemap.types.tracking import Scale, Tracked, Trajectory
from tests.planes import CAMERA, FRAME_NS, swaying

T_CAM_GAZE = Pose.from_rotvec([0.14, -0.05, 0.03], [0.045, -0.02, 0.01])
EYES = Camera(
    width_px=800,
    height_px=600,
    K=np.array([[430.0, 0, 395], [0, 432, 304], [0, 0, 1]]),
    distortion=np.array([-0.2, 0.05, 0.0, 0.0]),
)
INFO = {
    "gaze_camera": {
        "camera_matrix": EYES.K.tolist(),
        "distortion_coefficients": EYES.distortion.tolist(),
        "width": 800,
        "height": 600,
        "T_scene_gaze": np.vstack(
            [np.column_stack([T_CAM_GAZE.R, T_CAM_GAZE.t]), [0, 0, 0, 1]]
        ).tolist(),
    }
}
POINTS = np.array([[0.0, 0.1, 0], [0.15, 0.2, 0], [-0.12, 0.05, 0], [0.05, 0.25, 0]])


class TwoCameras:
    """A session of gaze alone."""

    overhead_camera = None

    def __init__(self, data: SessionData):
        self.data = data


@pytest.fixture
def located() -> Located:
    tracked = [Tracked(t_ns=n * FRAME_NS, T_world_cam=T) for n, T in enumerate(swaying(90))]
    path = Trajectory.from_outcomes(tracked, scale=Scale.METRIC)
    return Located(
        slam=SlamResult(trajectory=path, outcomes=(), map=None, camera=CAMERA),
        T_world_overhead=None,
    )


def looks_at(points, trajectory):
    for n, point in enumerate(points):
        mid_ns = (10 + 20 * n) * FRAME_NS + FRAME_NS // 3
        T_world_gaze = trajectory.at(mid_ns) @ T_CAM_GAZE
        u_px, v_px = EYES.project(T_world_gaze.inverse().transform(point)[None])[0]
        yield Fixation(fixation_id=n, start_ns=mid_ns - 9, end_ns=mid_ns + 9, u_px=u_px, v_px=v_px)


def bare_table():
    background = table_mesh(np.array([[-0.8, -0.6], [0.8, 0.6]]))
    return SceneModel(
        mesh=background,
        background=background,
        objects=(),
        T_world_overhead=None,
        surface_sigma_m=0.0005,
    )


def find(located, info):
    fixations = tuple(looks_at(POINTS, located.slam.trajectory))
    session = TwoCameras(SessionData(name="rig", fixations=fixations, info=info))
    config = MappingConfig(offset_mode=OffsetMode.OFF)
    return find_looks(session, located, bare_table(), config).fixations


def test_gaze_of_the_other_camera_meets_what_was_looked_at(located):
    found = find(located, INFO)
    assert [f.hit for f in found] == [HitKind.SURFACE] * 4
    for look, point in zip(found, POINTS, strict=True):
        assert np.linalg.norm(look.point_world - point) < 2e-4
        T_world_cam = located.slam.trajectory.at(look.fixation.mid_ns)
        in_scene_px = CAMERA.project(T_world_cam.inverse().transform(point)[None])[0]
        assert look.scene_uv_px == pytest.approx(in_scene_px, abs=0.2)
        eyes_m = (T_world_cam @ T_CAM_GAZE).t
        assert np.linalg.norm(look.origin_world - eyes_m) < 1e-4


def test_without_the_extrinsics_it_would_be_centimetres_off(located):
    found = [f for f in find(located, {}) if f.point_world is not None]
    errors = [np.linalg.norm(f.point_world - POINTS[f.fixation.fixation_id]) for f in found]
    assert min(errors) > 0.02


def find_live(located, info):
    """Return what the live service casts, look by look."""
    looks = LiveLooks(CAMERA, noise=GazeNoise(), offset=OffsetConfig(), eyes=gaze_camera_in(info))
    path, surface, found = RecentPath(), SceneCaster(bare_table()), []
    waiting = list(looks_at(POINTS, located.slam.trajectory))
    for n, t_ns in enumerate(located.slam.trajectory.t_ns.tolist()):
        path.add(Tracked(t_ns=t_ns, T_world_cam=located.slam.trajectory.pose(n)))
        path.last_ns = t_ns
        if waiting and waiting[0].end_ns < t_ns:
            looks.add(waiting.pop(0))
        found += looks.cast_due(path, surface, scale=Scale.METRIC)
    return found


def test_live_gaze_of_the_other_camera_meets_the_same_points(located):
    found, offline = find_live(located, INFO), find(located, INFO)
    assert len(found) == len(POINTS)
    for look, point, other in zip(found, POINTS, offline, strict=True):
        assert np.linalg.norm(look.point_world - point) < 2e-4
        assert look.scene_uv_px == pytest.approx(other.scene_uv_px, abs=0.05)
        assert look.cov_world == pytest.approx(other.cov_world, rel=0.05, abs=1e-9)
    wrong = [f for f in find_live(located, {}) if f.point_world is not None]
    assert min(np.linalg.norm(f.point_world - POINTS[f.fixation.fixation_id]) for f in wrong) > 0.02


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"T_scene_gaze": [1, 2]}, "4x4"),
        ({"T_scene_gaze": (2 * np.eye(4) - np.diag([0, 0, 0, 1])).tolist()}, "rotation"),
        ({"width": None}, "width"),
        ({"camera_matrix": [1, 2]}, "3x3"),
    ],
)
def test_a_wrong_description_is_one_line(change, said):
    described = {**INFO["gaze_camera"], **change}
    data = replace(SessionData(name="rig"), info={"gaze_camera": described})
    with pytest.raises(InputError, match=said):
        gaze_camera_of(data)
