"""Poses that were published keep their place beside the keyframes of their map."""

import numpy as np
import pytest

from gazemap.geometry.align import Similarity
from gazemap.geometry.pose import Pose
from gazemap.slam.live.following import KeyframeFollower
from gazemap.slam.live.landmarks import Landmarks
from gazemap.slam.live.messages import MapUpdate
from gazemap.types.map import MapEvent, MapEventKind
from gazemap.types.tracking import Scale
from tests.planes import swaying

POSES = swaying(90)
KEYFRAMES = (0, 20, 40, 60)
S = Similarity(scale=2.0, R=Pose.from_rotvec([0, 0, 0.3], [0, 0, 0]).R, t=np.array([0.1, 0, 0.2]))


def update(poses, *, map_id=0):
    """Return a map with keyframes of these poses, by the time of each."""
    return MapUpdate(
        keyframe_id=0,
        T_cam_world=Pose.identity(),
        landmarks=Landmarks.none(),
        new_ids=np.empty(0, np.int64),
        keyframe_centres_world=np.array([T.t for T in poses.values()]),
        keyframe_axes_world=np.array([T.R[:, 2] for T in poses.values()]),
        keyframe_t_ns=np.array(list(poses)),
        keyframe_poses=tuple(poses.values()),
        map_id=map_id,
        scale=Scale.ARBITRARY,
    )


def event(kind, *, old_map_id=0, map_id=0):
    return MapEvent(kind=kind, t_ns=0, map_id=map_id, old_map_id=old_map_id, S_new_old=S)


def follower():
    one = KeyframeFollower()
    assert one.take(update({n: POSES[n] for n in KEYFRAMES}), ()) is None
    return one


@pytest.mark.parametrize(
    ("kind", "map_id"), [(MapEventKind.RE_ANCHORED, 0), (MapEventKind.MERGED, 3)]
)
def test_a_map_that_is_scaled_or_merged_takes_all_its_poses_along(kind, map_id):
    now = {n: S.transform_pose(POSES[n]) for n in KEYFRAMES}
    moves = follower().take(update(now, map_id=map_id), (event(kind, map_id=map_id),))
    assert (moves.old_map_id, moves.map_id) == (0, map_id)
    for n in (3, 33, 58, 80):
        got, expected = moves.moved(n, POSES[n]), S.transform_pose(POSES[n])
        assert got.t == pytest.approx(expected.t, abs=1e-9)
        assert pytest.approx(expected.R, abs=1e-9) == got.R


def test_a_map_that_bends_takes_each_pose_along_with_its_own_keyframe():
    """A closed loop, or bundle adjustment: the far end moves, the beginning stays."""
    shift = {0: 0.0, 20: 0.02, 40: 0.05, 60: 0.1}
    now = {n: Pose(R=POSES[n].R, t=POSES[n].t + np.array([shift[n], 0, 0])) for n in KEYFRAMES}
    moves = follower().take(update(now), ())
    assert moves.moved(4, POSES[4]) is None
    for n, near in ((22, 20), (39, 40), (75, 60)):
        assert moves.moved(n, POSES[n]).t - POSES[n].t == pytest.approx([shift[near], 0, 0])


def test_moves_too_small_to_tell_are_not_lost_when_they_add_up():
    one, moved_m = follower(), []
    for k in range(1, 6):
        now = {
            n: Pose(R=POSES[n].R, t=POSES[n].t + np.array([0.0004 * k, 0, 0])) for n in KEYFRAMES
        }
        moves = one.take(update(now), ())
        moved_m.append(0.0 if moves is None else moves.moved(20, POSES[20]).t[0] - POSES[20].t[0])
    assert moved_m == pytest.approx([0, 0, 0.0012, 0, 0], abs=1e-9)


def test_a_new_map_moves_nothing_of_the_one_before():
    one = follower()
    begun = update({100: POSES[80]}, map_id=1)
    assert one.take(begun, (event(MapEventKind.NEW_MAP, map_id=1),)) is None
    assert one.take(begun, ()) is None
