"""What a rig says of itself holds for its session, and no longer."""

import numpy as np

from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Pose
from gazemap.types.session import LayoutTag, TagLayout
from gazemap.wire import images, rig
from gazemap.wire.streams import Stream
from services.introduction import Introduction


def calibration(focal_px):
    K = np.array([[focal_px, 0, 160], [0, focal_px, 120], [0, 0, 1]])
    camera = Camera(width_px=320, height_px=240, K=K, distortion=np.zeros(5))
    return images.encode_calibration(camera, frame_id="head")


TAGS = rig.encode_tags(
    TagLayout(
        family="tag36h11", tags=(LayoutTag(tag_id=0, size_m=0.06, T_world_tag=Pose.identity()),)
    )
)


def test_the_tags_of_one_session_do_not_set_the_world_of_the_next():
    now_s = [0.0]
    told = Introduction(now_s=lambda: now_s[0])
    told.hear(Stream.TAGS, TAGS)
    told.hear(Stream.HEAD_CALIBRATION, calibration(300.0))
    now_s[0] = 10.0
    told.begin_session()
    assert told.layout is None
    assert told.head is None


def test_what_arrives_just_before_its_session_belongs_to_it():
    now_s = [0.0]
    told = Introduction(now_s=lambda: now_s[0])
    told.hear(Stream.TAGS, TAGS)
    now_s[0] = 0.2
    told.begin_session()
    assert told.layout is not None


def test_only_another_camera_is_news():
    told = Introduction()
    assert told.hear(Stream.HEAD_CALIBRATION, calibration(300.0))
    assert not told.hear(Stream.HEAD_CALIBRATION, calibration(300.0))
    assert told.hear(Stream.HEAD_CALIBRATION, calibration(310.0))
