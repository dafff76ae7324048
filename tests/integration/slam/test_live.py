"""Live tracking on drawn planes, against the exact truth."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from gazemap.errors import InputError
from gazemap.geometry.align import fit_similarity
from gazemap.slam.live.config import LiveConfig
from gazemap.slam.live.tracker import LiveTracker
from gazemap.types.frame import Frame
from gazemap.types.map import MapEventKind
from gazemap.types.session import TagLayout
from gazemap.types.tracking import Lost, LostReason, Scale, Tracked
from tests.planes import CAMERA, FRAME_NS, box_front, draw, hall, ring, room, swaying, tag, turning

CONFIG = LiveConfig(in_process=True, lag_frames=3)
BLANK = np.full((CAMERA.height_px, CAMERA.width_px), 7, np.uint8)


def frames_of(images, *, first=0):
    for n, image in enumerate(images, first):
        yield Frame(index=n, t_ns=10**18 + n * FRAME_NS, image=image)


def run(tracker, images, *, first=0):
    return [tracker.track(frame) for frame in frames_of(images, first=first)]


def aligned_errors_m(outcomes, poses):
    """Return the errors (N,) of the tracked frames after the best similarity, and that scale."""
    pairs = [
        (o.T_world_cam.t, T.t)
        for o, T in zip(outcomes, poses, strict=True)
        if isinstance(o, Tracked)
    ]
    estimate, truth = (np.array(x) for x in zip(*pairs, strict=True))
    S = fit_similarity(estimate, truth)
    return np.linalg.norm(S.transform(estimate) - truth, axis=1), S


@pytest.fixture(scope="module")
def clean():
    poses = swaying(150)
    images = [draw(room(), T) for T in poses]
    with LiveTracker(CAMERA, config=CONFIG) as tracker:
        return poses, images, run(tracker, images), tracker.take_events(), tracker.points_world()


def test_a_static_room_is_tracked_within_a_millimetre(clean):
    poses, _, outcomes, events, points = clean
    tracked = [o for o in outcomes if isinstance(o, Tracked)]
    errors, _ = aligned_errors_m(outcomes, poses)
    assert len(tracked) > 0.9 * len(outcomes)
    assert 1e-6 < np.sqrt((errors**2).mean()) < 1e-3
    assert [e.kind for e in events] == [MapEventKind.NEW_MAP]
    assert len(points) > 150


def test_points_lie_on_the_planes(clean):
    poses, _, outcomes, _, points = clean
    _, S = aligned_errors_m(outcomes, poses)
    off = []
    for item in room():
        normal = np.cross(item.x, item.y)
        off.append(np.abs((S.transform(points) - item.corner) @ normal) / np.linalg.norm(normal))
    assert np.median(np.min(off, axis=0)) < 0.002


def test_the_covariance_is_of_the_errors_size(clean):
    poses, _, outcomes, _, _ = clean
    errors, S = aligned_errors_m(outcomes, poses)
    sigmas = [
        S.scale * np.sqrt(np.trace(o.cov_cam[3:, 3:])) for o in outcomes if isinstance(o, Tracked)
    ]
    assert 0.2 < np.median(errors) / np.median(sigmas) < 5


def test_the_same_frames_give_the_same_poses(clean):
    _, images, outcomes, _, _ = clean
    with LiveTracker(CAMERA, config=CONFIG) as tracker:
        again = run(tracker, images[:60])
    for a, b in zip(outcomes, again, strict=False):
        assert type(a) is type(b)
        if isinstance(a, Tracked):
            np.testing.assert_array_equal(a.T_world_cam.matrix, b.T_world_cam.matrix)


def test_without_parallax_there_is_no_map():
    turning = [draw(room(), replace(T, t=np.array([0.0, -0.75, 0.62]))) for T in swaying(30)]
    with LiveTracker(CAMERA, config=CONFIG) as tracker:
        outcomes = run(tracker, turning)
        assert tracker.scale is Scale.ARBITRARY
    assert {o.reason for o in outcomes} == {LostReason.STARTING}


def test_forty_blank_frames_are_lost_and_the_track_comes_back(clean):
    poses, images, clean_outcomes, _, _ = clean
    images = [BLANK if 60 <= n < 100 else image for n, image in enumerate(images)]
    with LiveTracker(CAMERA, config=CONFIG) as tracker:
        outcomes = run(tracker, images)
        kinds = [e.kind for e in tracker.take_events()]
    assert all(o == Lost(t_ns=o.t_ns, reason=LostReason.BLANK) for o in outcomes[60:100])
    back = next(n for n, o in enumerate(outcomes) if n >= 100 and isinstance(o, Tracked))
    assert back < 130
    assert outcomes[back].is_relocalised
    assert kinds == [MapEventKind.NEW_MAP, MapEventKind.LOST, MapEventKind.RELOCALISED]
    before, _ = aligned_errors_m(clean_outcomes, poses)
    after, _ = aligned_errors_m(outcomes, poses)
    assert np.sqrt((after**2).mean()) < 1.3 * np.sqrt((before**2).mean()) + 1e-4


def test_a_carried_textured_box_does_not_bend_the_map(clean):
    poses, _, _, _, _ = clean
    images = []
    for n, T in enumerate(poses):
        across = np.clip((n - 40) / 70, 0, 1)
        front = box_front([0.35 - 0.7 * across, -0.15, 0.2], 0.22)
        images.append(draw([*room(), front], T))
    with LiveTracker(CAMERA, config=CONFIG) as tracker:
        outcomes = run(tracker, images)
        points = tracker.points_world()
    errors, S = aligned_errors_m(outcomes, poses)
    assert np.sqrt((errors**2).mean()) < 2e-3
    table = S.transform(points)
    table = table[(np.abs(table[:, 2]) < 0.03) & (np.abs(table[:, 0]) < 0.6)]
    assert len(table) > 30
    assert np.median(np.abs(table[:, 2])) < 2e-3


def carried(T_world_cam, n):
    """Return a colour image of a box that an arm carries over, and which pixels are the two."""
    part = np.clip((n - 40) / 100, 0, 1)
    centre = np.array([0.35 - 0.7 * part, -0.15, 0.1 + 0.25 * np.sin(np.pi * part)])
    still = draw(room(), T_world_cam)
    image = cv2.cvtColor(draw([*room(), box_front(centre, 0.2)], T_world_cam), cv2.COLOR_GRAY2BGR)
    u, v = CAMERA.project(T_world_cam.inverse().transform(centre[None]))[0]
    arm = np.array([[u - 14, v], [u + 14, v], [u + 70, CAMERA.height_px], [u, CAMERA.height_px]])
    cv2.fillPoly(image, [arm.astype(np.int32)], (118, 148, 204))
    return image, (image != still[..., None]).any(axis=2)


def test_the_mask_covers_a_carried_box_and_its_arm_and_little_else():
    poses = swaying(150)
    covered, spilt = [], []
    with LiveTracker(CAMERA, config=CONFIG) as tracker:
        outcomes = []
        for n, T in enumerate(poses):
            image, truth = carried(T, n)
            outcomes.append(tracker.track(Frame(index=n, t_ns=10**18 + n * FRAME_NS, image=image)))
            if 70 <= n < 135:
                size = (CAMERA.width_px, CAMERA.height_px)
                mask = cv2.resize(tracker.moving_mask().astype(np.uint8), size, interpolation=0) > 0
                near = cv2.dilate(truth.astype(np.uint8), np.ones((51, 51), np.uint8)) > 0
                covered.append(mask[truth].mean())
                spilt.append(mask[~near].mean())
    assert 0.7 < np.mean(covered) < 1.0
    assert np.mean(spilt) < 0.02
    errors, _ = aligned_errors_m(outcomes, poses)
    assert np.sqrt((errors**2).mean()) < 2e-3


def test_tags_give_the_pose_before_there_is_parallax_and_metres_after():
    places = [(0, [-0.45, 0.2, 0.0]), (3, [0.4, 0.25, 0.0]), (7, [0.05, -0.3, 0.0])]
    sheets, entries = zip(*(tag(k, centre, 0.09) for k, centre in places), strict=True)
    layout = TagLayout(family="tag36h11", tags=entries)
    moving = swaying(60)
    poses = [moving[0]] * 10 + moving
    images = [draw([*room(), *sheets], T) for T in poses]
    with LiveTracker(CAMERA, layout=layout, config=CONFIG) as tracker:
        outcomes = run(tracker, images)
        assert tracker.scale is Scale.METRIC
    assert all(isinstance(o, Tracked) for o in outcomes)
    off = [np.linalg.norm(o.T_world_cam.t - T.t) for o, T in zip(outcomes, poses, strict=True)]
    assert np.max(off[:10]) < 0.02
    assert 1e-5 < np.median(off[-30:]) < 0.003


def test_a_saved_map_is_loaded_and_recognised(clean, tmp_path):
    poses, images, _, _, _ = clean
    path = tmp_path / "kitchen.map"
    with LiveTracker(CAMERA, config=CONFIG) as tracker:
        first = run(tracker, images)
        tracker.save(path)
        count = len(tracker.points_world())
    later = swaying(60, phase=2.3)
    with LiveTracker(CAMERA, config=CONFIG) as tracker:
        tracker.load(path)
        assert len(tracker.points_world()) == count
        second = run(tracker, [draw(room(), T) for T in later], first=5000)
        extended = len(tracker.points_world())
    assert all(isinstance(o, Tracked) for o in second)
    assert second[0].is_relocalised
    assert extended >= 0.9 * count
    _, S = aligned_errors_m(first, poses)
    off = [S.transform(o.T_world_cam.t) - T.t for o, T in zip(second, later, strict=True)]
    assert np.sqrt((np.array(off) ** 2).sum(axis=1).mean()) < 2e-3


@pytest.mark.parametrize("content", [b"", b"no map", b"PK\x05\x06" + bytes(18)])
def test_a_damaged_map_is_refused_in_one_line(tmp_path, content):
    path = tmp_path / "broken.map"
    path.write_bytes(content)
    with LiveTracker(CAMERA, config=CONFIG) as tracker, pytest.raises(InputError, match="broken"):
        tracker.load(path)


def test_a_new_map_is_merged_when_it_meets_the_old():
    """Carried blindly to the other table, then back in sight: two maps become one."""
    config = replace(CONFIG, new_map_after_s=0.3)
    away = np.concatenate([np.full(45, 2.0), np.linspace(2.0, 0.0, 100), np.zeros(25)])
    poses = swaying(60)
    poses += [
        replace(T, t=T.t + np.array([x, 0, 0]))
        for T, x in zip(swaying(170, phase=2.0), away, strict=True)
    ]
    images = [draw(hall(), T) for T in poses]
    images[60:66] = [BLANK] * 6
    with LiveTracker(CAMERA, config=config) as tracker:
        outcomes = run(tracker, images)
        events = tracker.take_events()
        assert tracker.map_id == 0
    assert [e.map_id for e in events if e.kind is MapEventKind.NEW_MAP] == [0, 1]
    merged = [e for e in events if e.kind is MapEventKind.MERGED]
    assert [(e.old_map_id, e.map_id) for e in merged] == [(1, 0)]
    _, S = aligned_errors_m(outcomes[:60], poses[:60])
    off = [
        np.linalg.norm(S.transform(o.T_world_cam.t) - T.t)
        for o, T in zip(outcomes[-20:], poses[-20:], strict=True)
        if isinstance(o, Tracked)
    ]
    assert len(off) == 20
    assert np.median(off) < 5e-3


def test_a_map_that_has_hardly_begun_is_not_waited_for():
    poses = swaying(60)
    images = [draw(room() if n < 16 else room(seed=70), T) for n, T in enumerate(poses)]
    with LiveTracker(CAMERA, config=CONFIG) as tracker:
        outcomes = run(tracker, images)
        events = tracker.take_events()
    lost_ns = next(e.t_ns for e in events if e.kind is MapEventKind.LOST)
    again_ns = [e.t_ns for e in events if e.kind is MapEventKind.NEW_MAP and e.t_ns > lost_ns]
    assert 0.25 < (again_ns[0] - lost_ns) * 1e-9 < 1.2
    assert isinstance(outcomes[-1], Tracked)
    assert outcomes[-1].map_id == 1


@pytest.mark.slow
def test_a_loop_is_closed_that_a_wrong_lens_had_opened():
    """A focal length that is 4 % off turns a full turn into less: only the loop can tell."""
    poses = turning(380, per_turn=300)
    wrong = replace(CAMERA, K=CAMERA.K * [[0.96, 1, 1], [1, 0.96, 1], [1, 1, 1]])
    images = []
    for T in poses:
        far_first = sorted(ring(), key=lambda w: -np.linalg.norm(w.corner + w.x / 2 - T.t))
        images.append(draw(far_first, T))
    with LiveTracker(wrong, config=CONFIG) as tracker:
        outcomes = run(tracker, images)
        closed = [e for e in tracker.take_events() if e.kind is MapEventKind.LOOP_CLOSED]
    assert closed
    assert 0.7 < closed[0].S_new_old.scale < 1.4
    _, S = aligned_errors_m(outcomes[:100], poses[:100])
    off = [
        np.linalg.norm(S.transform(o.T_world_cam.t) - T.t)
        for o, T in zip(outcomes, poses, strict=True)
        if isinstance(o, Tracked)
    ]
    opened = np.median(off[-100:-60])
    assert opened > 0.08
    assert np.median(off[-15:]) < 0.3 * opened
