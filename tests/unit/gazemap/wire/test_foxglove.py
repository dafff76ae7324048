"""Who knows Foxglove's schemas alone reads our messages, and ours reads theirs."""

import cv2
import numpy as np
import pytest
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.CompressedVideo_pb2 import CompressedVideo
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from gazemap.errors import InputError
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Pose
from gazemap.types.tracking import Scale, Tracked
from gazemap.wire import images, mapping


def test_a_pose_is_a_foxglove_pose():
    tracked = Tracked(t_ns=1_500_000_000, T_world_cam=Pose(R=np.eye(3), t=np.array([1.0, 2, 3])))
    message = PoseInFrame()
    message.ParseFromString(
        mapping.encode_pose(mapping.PublishedPose(tracked=tracked, scale=Scale.METRIC))
    )
    assert (message.timestamp.seconds, message.timestamp.nanos) == (1, 500_000_000)
    assert message.frame_id == "world"
    assert (message.pose.position.y, message.pose.orientation.w) == (2, 1)


def test_a_calibration_is_a_foxglove_calibration():
    camera = Camera(
        width_px=8, height_px=6, K=np.diag([5.0, 5, 1]), distortion=np.zeros(8), readout_s=0.01
    )
    message = CameraCalibration()
    message.ParseFromString(images.encode_calibration(camera, frame_id="head"))
    assert (message.width, message.height) == (8, 6)
    assert message.distortion_model == "rational_polynomial"
    assert list(message.P) == [5, 0, 0, 0, 0, 5, 0, 0, 0, 0, 1, 0]


def test_a_plain_foxglove_image_is_read():
    pixels = np.full((4, 5, 3), 7, dtype=np.uint8)
    message = CompressedImage(data=cv2.imencode(".png", pixels)[1].tobytes(), format="png")
    message.timestamp.nanos = 9
    frame = images.decode_image(message.SerializeToString(), stream="head/image")
    np.testing.assert_array_equal(frame.image, pixels)
    assert frame.t_ns == 9


def test_a_packet_has_foxgloves_name_of_its_codec():
    packet = images.VideoPacket(index=1, t_ns=2, codec="hevc", data=b"x")
    payload = images.encode_packet(packet, frame_id="head")
    assert CompressedVideo.FromString(payload).format == "h265"
    assert images.decode_packet(payload, stream="head/image") == packet


def test_a_video_packet_where_an_image_is_expected_is_named():
    packet = images.VideoPacket(index=1, t_ns=2, codec="h264", data=b"x")
    payload = images.encode_packet(packet, frame_id="head")
    with pytest.raises(InputError, match="a packet of h264 video, an image expected"):
        images.decode_image(payload, stream="head/image")
