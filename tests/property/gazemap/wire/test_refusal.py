"""Bytes that are no message are refused in one line, whatever they are."""

from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gazemap.errors import InputError
from gazemap.wire import images, mapping, rig, surface

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
