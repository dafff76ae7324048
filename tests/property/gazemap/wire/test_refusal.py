"""Bytes that are no message are refused in one line, whatever they are."""

from functools import partial

import pytest
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.TriangleListPrimitive_pb2 import TriangleListPrimitive
from hypothesis import given
from hypothesis import strategies as st

from gazemap.errors import InputError
from gazemap.wire import images, mapping, rig, surface
from gazemap.wire.generated import gazemap_streams_pb2 as pb

OURS = [
    rig.decode_session,
    rig.decode_gaze,
    rig.decode_device_fixation,
    rig.decode_blink,
    rig.decode_event,
    rig.decode_imu,
    rig.decode_cue,
    rig.decode_tags,
    mapping.decode_fixation,
    mapping.decode_object,
    mapping.decode_map_event,
    mapping.decode_status,
]
FOXGLOVES = [
    mapping.decode_pose,
    partial(mapping.decode_transform, stream="t"),
    surface.decode_points,
    surface.decode_mesh,
    partial(images.decode_calibration, stream="c"),
    partial(images.decode_image, stream="i"),
    partial(images.decode_depth, stream="d"),
    partial(images.decode_packet, stream="p"),
]


@pytest.mark.parametrize("decode", [*OURS, *FOXGLOVES])
@given(payload=st.binary(max_size=80))
def test_garbage_never_raises_anything_but_an_input_error(decode, payload):
    line = ""
    try:
        decode(payload)
    except InputError as error:
        line = str(error)
    assert "\n" not in line


@pytest.mark.parametrize("decode", OURS)
@pytest.mark.parametrize("payload", [b"", b"\x08\x02", b"\xff\xff\xff", b"hello"])
def test_no_version_or_another_is_refused(decode, payload):
    with pytest.raises(InputError):
        decode(payload)


@pytest.mark.parametrize("decode", FOXGLOVES)
def test_another_version_beside_a_foxglove_message_is_refused(decode):
    version_99 = b"\xc0\x3e\x63"  # field 1000, varint
    with pytest.raises(InputError, match="version 99"):
        decode(version_99)


def test_what_a_message_must_not_hold_is_refused():
    """Bytes that parse, of the right version, and still make no record."""
    wrong = [
        (rig.decode_session, pb.SessionInfo(version=1, info_json="[1]")),
        (rig.decode_session, pb.SessionInfo(version=1, info_json="{")),
        (rig.decode_imu, pb.ImuSample(version=1, gyro_rad_s=[1, 2], accel_m_s2=[1, 2, 3])),
        (rig.decode_device_fixation, pb.DeviceFixation(version=1, u_px=float("inf"))),
        (rig.decode_tags, pb.TagLayout(version=1, tags=[pb.TagLayout.Tag(id=1)])),
        (mapping.decode_fixation, pb.Fixation3D(version=1)),
        (mapping.decode_fixation, pb.Fixation3D(version=1, hit=1, scene_uv_px=[1])),
        (mapping.decode_map_event, pb.MapEvent(version=1)),
        (mapping.decode_status, pb.ServiceStatus(version=1)),
        (mapping.decode_object, pb.SceneObject(version=1, size_m=[1])),
    ]
    for decode, message in wrong:
        with pytest.raises(InputError):
            decode(message.SerializeToString())


def test_foxglove_messages_that_make_no_record_are_refused():
    points = PointCloud(point_stride=16, data=b"1" * 16)
    triangles = TriangleListPrimitive(indices=[0, 1, 2])
    mesh = SceneUpdate(entities=[SceneEntity(triangles=[triangles])])
    wrong = [
        (surface.decode_points, points),
        (surface.decode_mesh, SceneUpdate()),
        (surface.decode_mesh, mesh),
        (mapping.decode_pose, PoseInFrame()),
        (partial(images.decode_calibration, stream="c"), CameraCalibration()),
        (
            partial(images.decode_calibration, stream="c"),
            CameraCalibration(distortion_model="plumb_bob", K=[1] * 8),
        ),
        (partial(images.decode_image, stream="i"), CompressedImage(data=b"no", format="webp")),
        (partial(images.decode_depth, stream="d"), CompressedImage(data=b"no", format="png")),
    ]
    for decode, message in wrong:
        with pytest.raises(InputError):
            decode(message.SerializeToString())
