"""A whole recording mapped offline, against the exact truth of a drawn room."""

from dataclasses import dataclass, field, replace

import cv2
import numpy as np
import pytest

from gazemap.geometry.align import fit_similarity
from gazemap.geometry.pose import Pose
from gazemap.session.tum_file import read_tum, write_tum
from gazemap.slam.colmap import write_colmap
from gazemap.slam.config import SlamConfig
from gazemap.slam.offline import map_session
from gazemap.types.frame import DepthFrame, Frame
from gazemap.types.session import LayoutTag, SessionData, TagLayout
from gazemap.types.tracking import Lost, LostReason, Scale, Tracked
from tests import planes

FRAME_COUNT = 90
TAG_SIZE = 0.12
TAG_PLACES = {0: (-0.5, -0.3), 1: (0.45, -0.25), 2: (-0.15, 0.28)}
UNPLACED_TAG = (3, (0.12, 0.2))


@dataclass
class DrawnSession:
    """A recording in memory."""

    images: list
    data: SessionData
    scene_camera: object = planes.CAMERA
    scene_t_ns: tuple = field(default=())
    overhead_camera: object = None
    depth_frames: tuple = ()

    def __post_init__(self):
        self.scene_t_ns = tuple(10**18 + i * planes.FRAME_NS for i in range(len(self.images)))

    def scene_frames(self):
        for i, (t_ns, image) in enumerate(zip(self.scene_t_ns, self.images, strict=True)):
            yield Frame(index=i, t_ns=t_ns, image=image)

    def overhead_frames(self):
        return iter(())

    def scene_depth_frames(self):
        return iter(self.depth_frames)


def tag_plane(tag_id, centre):
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    marker = cv2.aruco.generateImageMarker(dictionary, tag_id, 320)
    texture = cv2.copyMakeBorder(marker, 40, 40, 40, 40, cv2.BORDER_CONSTANT, value=255)
    side = TAG_SIZE * 400 / 320
    corner = np.array([centre[0] - side / 2, centre[1] + side / 2, 0.0])
    return planes.Plane(corner, np.array([side, 0, 0]), np.array([0, -side, 0]), texture)


def drawn(room, T_world_cam, times=3):
    """Draw finer and average: a tag's edge is to lie where it is, not at the nearest pixel."""
    K = planes.CAMERA.K * times
    K[:2, 2] += (times - 1) / 2
    K[2, 2] = 1
    width, height = planes.CAMERA.width_px, planes.CAMERA.height_px
    fine = replace(planes.CAMERA, width_px=width * times, height_px=height * times, K=K)
    image = planes.draw(room, T_world_cam, fine)
    return cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)


def layout():
    tags = tuple(
        LayoutTag(tag_id=i, size_m=TAG_SIZE, T_world_tag=Pose(R=np.eye(3), t=[*xy, 0.0]))
        for i, xy in TAG_PLACES.items()
    )
    return TagLayout(family="tag36h11", tags=tags)


@pytest.fixture(scope="module")
def poses():
    return planes.swaying(FRAME_COUNT)


@pytest.fixture(scope="module")
def session(poses):
    room = planes.room()
    room[3:3] = [tag_plane(i, xy) for i, xy in [*TAG_PLACES.items(), UNPLACED_TAG]]
    images = [drawn(room, T_world_cam) for T_world_cam in poses]
    return DrawnSession(images=images, data=SessionData(name="drawn", tags=layout()))


@pytest.fixture(scope="module")
def result(session):
    return map_session(session, SlamConfig())


def truth_of(outcomes, poses):
    pairs = [(o, T) for o, T in zip(outcomes, poses, strict=True) if isinstance(o, Tracked)]
    return (
        np.array([o.T_world_cam.t for o, _ in pairs]),
        np.array([T.t for _, T in pairs]),
    )


def rmse(a, b):
    return float(np.sqrt(((a - b) ** 2).sum(axis=1).mean()))


def test_tags_make_the_path_metric_to_a_millimetre(result, poses):
    estimated, true = truth_of(result.outcomes, poses)
    assert result.trajectory.scale is Scale.METRIC
    assert len(estimated) == FRAME_COUNT
    assert 1e-6 < rmse(estimated, true) < 2e-3


def test_without_tags_the_scale_is_said_to_be_arbitrary(session, poses):
    result = map_session(session, SlamConfig(), use_tags=False)
    estimated, true = truth_of(result.outcomes, poses)
    S_true_estimated = fit_similarity(estimated, true)
    assert result.trajectory.scale is Scale.ARBITRARY
    assert 1e-6 < rmse(S_true_estimated.transform(estimated), true) < 1e-3


def depth_of(room, T_world_cam):
    """Return the depth image of planes: what covers what is found by drawing their numbers."""
    height, width = planes.CAMERA.height_px, planes.CAMERA.width_px
    depth = np.full((height, width), np.nan, np.float32)
    v, u = np.mgrid[:height, :width]
    rays = np.dstack([u, v, np.ones_like(u)]) @ np.linalg.inv(planes.CAMERA.K).T
    for item in room:
        basis = np.linalg.inv(
            T_world_cam.R.T @ np.column_stack([item.x, item.y, item.corner - T_world_cam.t])
        )
        a, b, inverse_z = np.moveaxis(rays @ basis.T, 2, 0)
        with np.errstate(divide="ignore", invalid="ignore"):
            inside = (inverse_z > 0) & (a >= 0) & (b >= 0)
            inside &= (a <= inverse_z) & (b <= inverse_z)
            depth = np.where(inside, 1 / inverse_z, depth).astype(np.float32)
    return depth


def test_depth_images_give_the_scale_where_there_are_no_tags(session, poses):
    frames = tuple(
        DepthFrame(t_ns=session.scene_t_ns[i], depth_m=depth_of(planes.room(), poses[i]))
        for i in range(0, FRAME_COUNT, 9)
    )
    result = map_session(replace(session, depth_frames=frames), SlamConfig(), use_tags=False)
    estimated, true = truth_of(result.outcomes, poses)
    assert result.trajectory.scale is Scale.METRIC
    S = fit_similarity(estimated, true)
    assert S.scale == pytest.approx(1, abs=0.01)
    assert rmse(S.transform(estimated), true) < 0.002


def test_a_tag_that_the_layout_lacks_is_surveyed(result):
    (tag,) = result.surveyed_tags
    tag_id, xy = UNPLACED_TAG
    assert tag.tag_id == tag_id
    assert tag.size_m == pytest.approx(TAG_SIZE, abs=0.001)
    assert np.linalg.norm(tag.T_world_tag.t - [*xy, 0]) < 0.001
    assert np.degrees(np.arccos((np.trace(tag.T_world_tag.R) - 1) / 2)) < 1.0


def test_the_size_of_tags_gives_the_scale_where_no_layout_does(session, poses):
    config = SlamConfig(tag_size_m=TAG_SIZE)
    result = map_session(replace(session, data=SessionData(name="drawn")), config)
    estimated, true = truth_of(result.outcomes, poses)
    assert result.trajectory.scale is Scale.METRIC
    assert fit_similarity(estimated, true).scale == pytest.approx(1, abs=0.005)
    assert {tag.tag_id for tag in result.surveyed_tags} >= {2, 3}


def test_a_wrong_focal_length_is_put_right_and_a_right_one_stays(session, result):
    assert result.camera.K[0, 0] == planes.CAMERA.K[0, 0]
    K = planes.CAMERA.K.copy()
    K[[0, 1], [0, 1]] *= 1.04
    wrong = replace(session, scene_camera=replace(planes.CAMERA, K=K))
    found = map_session(wrong, SlamConfig(), use_tags=False).camera.K[0, 0]
    assert found == pytest.approx(planes.CAMERA.K[0, 0], rel=0.005)


def test_points_lie_on_the_planes_within_a_few_sigma(result):
    z = result.map.points_world[:, 2]
    sigma = np.sqrt(result.map.cov_world[:, 2, 2])
    x, y = result.map.points_world[:, 0], result.map.points_world[:, 1]
    on_table = (np.abs(z) < 0.02) & (np.abs(x) < 0.65) & (y > -0.45) & (y < 0.4)
    assert on_table.sum() > 50
    assert np.median(np.abs(z[on_table])) < 3e-3
    assert 1e-5 < np.median(sigma[on_table]) < 5e-3


def test_the_same_input_gives_the_same_path_to_the_bit(session, result):
    again = map_session(session, SlamConfig())
    assert np.array_equal(again.trajectory.p_world_cam, result.trajectory.p_world_cam)
    assert np.array_equal(again.trajectory.quat_xyzw, result.trajectory.quat_xyzw)
    assert np.array_equal(again.map.points_world, result.map.points_world)


def test_frames_that_do_not_fit_into_memory_change_nothing(session, result):
    frugal = replace(SlamConfig(), memory_bytes=20 * 400 * 300)
    again = map_session(session, frugal)
    assert np.array_equal(again.trajectory.p_world_cam, result.trajectory.p_world_cam)


def test_a_black_out_is_lost_and_the_rest_stays_in_one_map(session, poses):
    images = list(session.images)
    for i in range(40, 60):
        images[i] = np.zeros_like(images[i])
    result = map_session(DrawnSession(images=images, data=session.data), SlamConfig())
    assert {o.reason for o in result.outcomes[40:60]} == {LostReason.BLANK}
    assert isinstance(result.outcomes[60], Tracked)
    assert result.outcomes[60].is_relocalised
    estimated, true = truth_of(result.outcomes, poses)
    assert len(estimated) == FRAME_COUNT - 20
    assert rmse(estimated, true) < 2e-3


def test_a_carried_textured_box_does_not_move_the_map(session, poses):
    images = []
    for i, (image, T_world_cam) in enumerate(zip(session.images, poses, strict=True)):
        centre = [-0.5 + 0.011 * i, -0.12, 0.15]
        box = planes.draw([planes.box_front(centre, 0.2)], T_world_cam)
        images.append(np.where(box != 90, box, image).astype(np.uint8))
    result = map_session(DrawnSession(images=images, data=session.data), SlamConfig())
    estimated, true = truth_of(result.outcomes, poses)
    assert len(estimated) >= 0.98 * FRAME_COUNT
    assert rmse(estimated, true) < 2e-3


def test_a_camera_that_only_turns_gets_no_map():
    here = np.array([0.0, -0.75, 0.62])
    turning = [
        planes.looking(here, [0.2 * np.sin(i / 10), 0.15 + 0.1 * np.cos(i / 7), 0.0])
        for i in range(40)
    ]
    images = [planes.draw(planes.room(), T_world_cam) for T_world_cam in turning]
    result = map_session(DrawnSession(images=images, data=SessionData(name="turn")), SlamConfig())
    assert all(isinstance(o, Lost) for o in result.outcomes)
    assert len(result.trajectory) == 0
    assert result.warnings


def test_pycolmap_opens_the_exported_map(result, tmp_path):
    import pycolmap

    write_colmap(result, tmp_path / "map")
    rec = pycolmap.Reconstruction(tmp_path / "map")
    assert rec.num_points3D() == len(result.map.points_world)
    assert rec.num_images() == len(result.map.keyframe_t_ns)
    assert 0.01 < rec.compute_mean_reprojection_error() < 0.6
    image = rec.images[1]
    row = int(np.flatnonzero(result.trajectory.t_ns == int(image.name))[0])
    centre = image.projection_center()
    assert np.allclose(centre, result.trajectory.p_world_cam[row], atol=1e-9)


def test_the_path_survives_its_file(result, tmp_path):
    write_tum(result.trajectory, tmp_path / "path.tum")
    back = read_tum(tmp_path / "path.tum")
    assert back.scale is Scale.METRIC
    assert np.allclose(back.p_world_cam, result.trajectory.p_world_cam, atol=1e-8)
