"""What is encoded is decoded again, to the bit where the wire is exact."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from gazemap.geometry.align import Similarity
from gazemap.geometry.camera import Camera, LensModel
from gazemap.geometry.pose import Pose
from gazemap.types.fixation import Fixation3D
from gazemap.types.frame import DepthFrame, Frame
from gazemap.types.map import MapEvent, MapEventKind
from gazemap.types.scene import HitKind, Mesh, ObjectState, SceneObject
from gazemap.types.session import (
    Blink,
    Cue,
    Event,
    Fixation,
    GazeSample,
    ImuSample,
    LayoutTag,
    TagLayout,
)
from gazemap.types.status import Level, ServiceStatus
from gazemap.types.tracking import Scale, Tracked
from gazemap.wire import images, mapping, rig, surface

times = st.integers(min_value=0, max_value=2**62)
ids = st.integers(min_value=0, max_value=2**40)
numbers = st.floats(min_value=-1e9, max_value=1e9)
words = st.text(max_size=20)
optional_words = st.none() | words


def vectors(count):
    return arrays(np.float64, count, elements=st.floats(-1e3, 1e3))


@st.composite
def poses(draw):
    turn = Rotation.from_rotvec(draw(arrays(np.float64, 3, elements=st.floats(-3, 3))))
    return Pose(R=turn.as_matrix(), t=draw(vectors(3)))


def assert_same_pose(a, b):
    np.testing.assert_allclose(a.R, b.R, atol=1e-12)
    np.testing.assert_array_equal(a.t, b.t)


def assert_same_array(a, b):
    assert (a is None) == (b is None)
    if a is not None:
        np.testing.assert_array_equal(a, b)


def same_number(a, b):
    return a == b or (math.isnan(a) and math.isnan(b))


@given(
    times, numbers | st.just(math.nan), numbers | st.just(math.nan), st.booleans(), st.booleans()
)
def test_gaze(t_ns, u_px, v_px, worn, blink):
    sample = GazeSample(t_ns=t_ns, u_px=u_px, v_px=v_px, worn=worn, blink=blink)
    back = rig.decode_gaze(rig.encode_gaze(sample))
    assert same_number(back.u_px, u_px)
    assert same_number(back.v_px, v_px)
    assert (back.t_ns, back.worn, back.blink) == (t_ns, worn, blink)


@given(ids, times, times, numbers, numbers)
def test_device_fixation(fixation_id, start_ns, end_ns, u_px, v_px):
    fixation = Fixation(
        fixation_id=fixation_id, start_ns=start_ns, end_ns=end_ns, u_px=u_px, v_px=v_px
    )
    assert rig.decode_device_fixation(rig.encode_device_fixation(fixation)) == fixation


@given(times, times, words)
def test_blink_event_and_cue(start_ns, end_ns, text):
    blink = Blink(start_ns=start_ns, end_ns=end_ns)
    assert rig.decode_blink(rig.encode_blink(blink)) == blink
    event = Event(t_ns=start_ns, name=text)
    assert rig.decode_event(rig.encode_event(event)) == event
    cue = Cue(start_ns=start_ns, end_ns=end_ns, text=text)
    assert rig.decode_cue(rig.encode_cue(cue)) == cue


@given(times, st.tuples(numbers, numbers, numbers), st.tuples(numbers, numbers, numbers))
def test_imu(t_ns, gyro, accel):
    sample = ImuSample(t_ns=t_ns, gyro_rad_s=gyro, accel_m_s2=accel)
    assert rig.decode_imu(rig.encode_imu(sample)) == sample


@given(words, st.lists(st.tuples(ids, st.floats(0.001, 1), poses()), max_size=4))
def test_tag_layout(family, entries):
    tags = tuple(LayoutTag(tag_id=i, size_m=size, T_world_tag=pose) for i, size, pose in entries)
    back = rig.decode_tags(rig.encode_tags(TagLayout(family=family, tags=tags)))
    assert back.family == family
    assert [(t.tag_id, t.size_m) for t in back.tags] == [(t.tag_id, t.size_m) for t in tags]
    for got, sent in zip(back.tags, tags, strict=True):
        assert_same_pose(got.T_world_tag, sent.T_world_tag)


@given(words, numbers, st.booleans(), st.dictionaries(words, ids), st.lists(words, max_size=3))
def test_session(name, heading, has_fixations, info, warnings):
    sent = rig.SessionInfo(
        name=name,
        wearer_heading_rad=heading,
        has_device_fixations=has_fixations,
        info=info,
        warnings=tuple(warnings),
    )
    assert rig.decode_session(rig.encode_session(sent)) == sent


@given(
    st.sampled_from([0, 4, 5, 8, 12, 14, "fisheye"]),
    st.none() | st.floats(0, 1),
    words,
    arrays(np.float64, 14, elements=st.floats(-1, 1)),
)
def test_calibration(kind, readout_s, serial, coefficients):
    lens = LensModel.FISHEYE if kind == "fisheye" else LensModel.PINHOLE
    camera = Camera(
        width_px=640,
        height_px=480,
        K=np.array([[500.5, 0, 320.1], [0, 501.5, 240.2], [0, 0, 1]]),
        distortion=coefficients[: 4 if kind == "fisheye" else kind],
        lens=lens,
        serial=serial,
        readout_s=readout_s,
    )
    payload = images.encode_calibration(camera, frame_id="head", t_ns=5)
    back = images.decode_calibration(payload, stream="head/calibration")
    np.testing.assert_array_equal(back.K, camera.K)
    np.testing.assert_array_equal(back.distortion, camera.distortion)
    assert (back.lens, back.serial, back.readout_s) == (lens, serial, readout_s)
    assert (back.width_px, back.height_px) == (640, 480)


@given(times, ids, st.booleans(), arrays(np.uint8, (6, 8, 3)))
def test_a_lossless_image(t_ns, index, is_grey, pixels):
    frame = Frame(index=index, t_ns=t_ns, image=pixels[..., 0] if is_grey else pixels)
    payload = images.encode_image(frame, frame_id="head", image_format=images.ImageFormat.PNG)
    back = images.decode_image(payload, stream="head/image")
    assert (back.index, back.t_ns) == (index, t_ns)
    np.testing.assert_array_equal(back.image, frame.image)


@given(times, ids, st.binary(max_size=50))
def test_video_packet(t_ns, index, data):
    packet = images.VideoPacket(index=index, t_ns=t_ns, codec="h264", data=data)
    payload = images.encode_packet(packet, frame_id="head")
    assert images.decode_packet(payload, stream="head/image") == packet


@given(times, arrays(np.uint16, (4, 5)))
def test_depth_to_the_millimetre(t_ns, depth_mm):
    depth_m = np.where(depth_mm == 0, np.nan, depth_mm / np.float32(1000)).astype(np.float32)
    payload = images.encode_depth(DepthFrame(t_ns=t_ns, depth_m=depth_m), frame_id="head")
    back = images.decode_depth(payload, stream="depth")
    assert back.t_ns == t_ns
    np.testing.assert_array_equal(back.depth_m, depth_m)


@given(times, poses(), st.none() | vectors((6, 6)), ids, st.booleans(), st.sampled_from(Scale))
def test_pose(t_ns, T_world_cam, cov_cam, map_id, is_relocalised, scale):
    tracked = Tracked(
        t_ns=t_ns,
        T_world_cam=T_world_cam,
        cov_cam=cov_cam,
        map_id=map_id,
        is_relocalised=is_relocalised,
    )
    sent = mapping.PublishedPose(tracked=tracked, scale=scale)
    back = mapping.decode_pose(mapping.encode_pose(sent))
    assert back.scale is scale
    assert (back.tracked.t_ns, back.tracked.map_id) == (t_ns, map_id)
    assert back.tracked.is_relocalised is is_relocalised
    assert_same_pose(back.tracked.T_world_cam, T_world_cam)
    assert_same_array(back.tracked.cov_cam, cov_cam)


@given(poses())
def test_transform(T_world_overhead):
    payload = mapping.encode_transform(T_world_overhead, parent="world", child="overhead", t_ns=3)
    assert_same_pose(mapping.decode_transform(payload, stream="overhead/pose"), T_world_overhead)


@given(
    ids,
    times,
    vectors(2),
    st.sampled_from(HitKind),
    st.none() | vectors(3),
    st.none() | vectors((3, 3)),
    st.none() | vectors(2),
    optional_words,
)
def test_fixation(fixation_id, t_ns, uv_px, hit, point, cov, overhead, object_id):
    sent = Fixation3D(
        fixation=Fixation(fixation_id=fixation_id, start_ns=t_ns, end_ns=t_ns + 5, u_px=1, v_px=2),
        scene_uv_px=uv_px,
        hit=hit,
        point_world=point,
        cov_world=cov,
        object_id=object_id,
        overhead_uv_px=overhead,
        reason="why",
    )
    back = mapping.decode_fixation(mapping.encode_fixation(sent))
    assert back.fixation == sent.fixation
    assert (back.hit, back.object_id, back.reason) == (hit, object_id, "why")
    for name in ("scene_uv_px", "point_world", "cov_world", "overhead_uv_px"):
        assert_same_array(getattr(back, name), getattr(sent, name))


@given(words, st.lists(st.tuples(times, st.none() | times, poses(), vectors((3, 3))), max_size=3))
def test_object(object_id, places):
    track = tuple(
        ObjectState(t_ns=t, left_ns=left, T_world_body=pose, cov_world=cov)
        for t, left, pose, cov in places
    )
    sent = SceneObject(
        object_id=object_id, size_m=np.array([0.1, 0.2, 0.3]), track=track, mean_bgr=np.ones(3)
    )
    back = mapping.decode_object(mapping.encode_object(sent))
    assert back.object_id == object_id
    np.testing.assert_array_equal(back.size_m, sent.size_m)
    assert [(s.t_ns, s.left_ns) for s in back.track] == [(s.t_ns, s.left_ns) for s in track]
    for got, want in zip(back.track, track, strict=True):
        assert_same_pose(got.T_world_body, want.T_world_body)
        np.testing.assert_array_equal(got.cov_world, want.cov_world)


@given(st.sampled_from(MapEventKind), times, ids, ids, st.none() | poses(), st.floats(0.01, 100))
def test_map_event(kind, t_ns, map_id, old_map_id, moved, scale):
    similarity = None if moved is None else Similarity(scale=scale, R=moved.R, t=moved.t)
    sent = MapEvent(
        kind=kind, t_ns=t_ns, map_id=map_id, old_map_id=old_map_id, S_new_old=similarity
    )
    back = mapping.decode_map_event(mapping.encode_map_event(sent))
    assert (back.kind, back.t_ns, back.map_id, back.old_map_id) == (kind, t_ns, map_id, old_map_id)
    assert (back.S_new_old is None) == (similarity is None)
    if similarity is not None:
        assert back.S_new_old.scale == scale
        np.testing.assert_array_equal(back.S_new_old.R, similarity.R)


@given(words, times, st.sampled_from(Level), st.lists(words), st.dictionaries(words, numbers))
def test_status(service, t_ns, level, messages, figures):
    sent = ServiceStatus(
        service=service, t_ns=t_ns, level=level, messages=tuple(messages), figures=figures
    )
    assert mapping.decode_status(mapping.encode_status(sent)) == sent


@given(times, arrays(np.float32, (5, 3), elements=st.floats(-99, 99, width=32)), st.integers(0, 5))
def test_points(t_ns, points_world, count):
    colours = np.arange(15, dtype=np.uint8).reshape(5, 3)
    sent = surface.MapPoints(
        t_ns=t_ns,
        points_world=points_world[:count].astype(np.float64),
        colours=colours[:count],
        scale=Scale.METRIC,
        map_id=3,
    )
    back = surface.decode_points(surface.encode_points(sent))
    assert (back.t_ns, back.scale, back.map_id) == (t_ns, Scale.METRIC, 3)
    np.testing.assert_array_equal(back.points_world, sent.points_world)
    np.testing.assert_array_equal(back.colours, sent.colours)


@given(
    vectors((4, 3)), arrays(np.uint8, (4, 3)), arrays(np.int64, (2, 3), elements=st.integers(0, 3))
)
def test_mesh(vertices, colours, triangles):
    sent = Mesh(vertices_world=vertices, triangles=triangles, colours=colours)
    back = surface.decode_mesh(surface.encode_mesh(sent, t_ns=1, scale=Scale.ARBITRARY))
    np.testing.assert_array_equal(back.vertices_world, vertices)
    np.testing.assert_array_equal(back.triangles, triangles)
    np.testing.assert_array_equal(back.colours, colours)
