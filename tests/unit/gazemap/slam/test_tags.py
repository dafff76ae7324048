import cv2
import numpy as np
import pytest

from gazemap.errors import InputError
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Pose
from gazemap.slam.tag_alignment import (
    TagSighting,
    align_to_tags,
    locate_static_camera,
)
from gazemap.slam.tags import TagDetector, TagView, fit_line
from gazemap.types.session import LayoutTag, TagLayout
from tests.planes import looking

CAMERA = Camera(
    width_px=640,
    height_px=480,
    K=[[520, 0, 318.2], [0, 521, 241.7], [0, 0, 1]],
    distortion=[-0.12, 0.05, 0.0004, -0.0003, 0.01],
)
SIDE_TEXELS = 600


def layout(places):
    tags = tuple(
        LayoutTag(tag_id=i, size_m=0.08, T_world_tag=Pose(R=np.eye(3), t=[*xy, 0.0]))
        for i, xy in enumerate(places)
    )
    return TagLayout(family="tag36h11", tags=tags)


def drawn(tags, T_world_cam, blur=0.7):
    """Ray-cast each pixel (four rays) onto the plane of the tags."""
    image = np.zeros((CAMERA.height_px, CAMERA.width_px))
    v, u = np.mgrid[: CAMERA.height_px, : CAMERA.width_px]
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    markers = [
        cv2.aruco.generateImageMarker(dictionary, tag.tag_id, SIDE_TEXELS) for tag in tags.tags
    ]
    for du, dv in ((-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)):
        pixels = np.column_stack([u.ravel() + du, v.ravel() + dv]).astype(float)
        rays = T_world_cam.rotate(CAMERA.unproject(pixels))
        points = T_world_cam.t - rays * (T_world_cam.t[2] / rays[:, 2])[:, None]
        value = np.full(len(points), 200.0)
        for tag, marker in zip(tags.tags, markers, strict=True):
            x, y = ((points - tag.T_world_tag.t)[:, :2] / tag.size_m + [0.5, -0.5]).T
            column, row = (x * SIDE_TEXELS).astype(int), (-y * SIDE_TEXELS).astype(int)
            on = (x >= 0) & (x < 1) & (y <= 0) & (y > -1)
            value[on] = 30 + marker[row[on], column[on]] * (170 / 255)
        image += value.reshape(image.shape) / 4
    return np.round(cv2.GaussianBlur(image, (0, 0), blur)).astype(np.uint8)


@pytest.fixture(scope="module")
def scene():
    tags = layout([(-0.2, -0.1), (0.2, -0.12), (0.02, 0.15)])
    T_world_cam = looking(np.array([0.05, -0.5, 0.6]), [0.0, 0.02, 0.0])
    return tags, T_world_cam, drawn(tags, T_world_cam)


def true_corners(tag, T_world_cam):
    world = tag.T_world_tag.transform(tag.corners_tag)
    return CAMERA.project(T_world_cam.inverse().transform(world))


def test_corners_lie_where_the_square_ends_within_a_tenth_of_a_pixel(scene):
    tags, T_world_cam, image = scene
    views = TagDetector(family="tag36h11", camera=CAMERA).detect(image)
    assert [view.tag_id for view in views] == [0, 1, 2]
    for view, tag in zip(views, tags.tags, strict=True):
        off = view.corners_px - true_corners(tag, T_world_cam)
        assert 1e-6 < np.abs(off).max() < 0.12
        assert np.abs(CAMERA.normalize(view.corners_px) - view.corners_norm).max() < 1e-9


def test_an_image_without_tags_shows_none():
    detector = TagDetector(family="tag36h11", camera=CAMERA)
    assert detector.detect(np.full((480, 640, 3), 90, np.uint8)) == ()


def test_an_unknown_family_is_refused_with_those_that_are_known():
    with pytest.raises(InputError, match="tag36h11"):
        TagDetector(family="tag99", camera=CAMERA)


def test_a_static_camera_is_found_within_a_millimetre(scene):
    tags, T_world_cam, image = scene
    T = locate_static_camera([image, image], CAMERA, layout=tags)
    assert 1e-7 < np.linalg.norm(T.t - T_world_cam.t) < 1e-3
    assert locate_static_camera([np.zeros_like(image)], CAMERA, layout=tags) is None


def test_an_outlier_does_not_turn_a_line():
    x = np.linspace(0, 1, 20)
    points = np.column_stack([x, 0.3 * x + 0.1])
    points[7, 1] += 0.2
    a, b, c = fit_line(points)
    assert abs(-a / b - 0.3) < 1e-3
    assert abs(-c / b - 0.1) < 1e-3


def test_a_map_of_another_scale_is_put_into_the_tags_world(scene):
    tags, *_ = scene
    rng = np.random.default_rng(5)
    turn = Pose.from_rotvec([0.3, -0.2, 0.5], [1.0, 2.0, 3.0])
    sightings = []
    for x in np.linspace(-0.3, 0.3, 8):
        T_world_cam = looking(np.array([x, -0.5, 0.6]), [0.0, 0.0, 0.0])
        T_map_cam = Pose(R=turn.R @ T_world_cam.R, t=2.5 * (turn.R @ T_world_cam.t) + turn.t)
        for tag in tags.tags:
            corners = true_corners(tag, T_world_cam) + rng.normal(0, 0.1, (4, 2))
            view = TagView(
                tag_id=tag.tag_id, corners_px=corners, corners_norm=CAMERA.normalize(corners)
            )
            sightings.append(TagSighting(T_map_cam=T_map_cam, view=view))
    S_world_map = align_to_tags(sightings, tags, focal_px=520.0)
    assert 1e-7 < abs(S_world_map.scale * 2.5 - 1) < 2e-3
    assert align_to_tags(sightings[:1], tags, focal_px=520.0) is None
