import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gazemap.geometry.align import Similarity, fit_similarity
from gazemap.geometry.pose import Pose
from gazemap.slam.front import Skeleton
from gazemap.slam.loops import Loop, agreeing, bend, merge_tracks
from gazemap.slam.structure import Structure

KEYFRAMES = 50
A_ROUND = 40
SEEN_FOR = 6
FOCAL_PX = 500.0


def true_pose(k):
    """Return T_world_cam of a walk around a circle, looking outwards."""
    angle = 2 * np.pi * k / A_ROUND
    ahead = np.array([np.cos(angle), np.sin(angle), 0.0])
    down = np.array([0.0, 0.0, -1.0])
    return Pose(R=np.column_stack([np.cross(down, ahead), down, ahead]), t=ahead)


def drift(k):
    """Return what moves the true surroundings of keyframe k to where the map has them."""
    turn = Rotation.from_rotvec([0.0, 0.0, 0.001 * k]).as_matrix()
    return Similarity(scale=1.001**k, R=turn, t=np.array([0.001 * k, 0.0, 0.001 * k]))


@pytest.fixture
def drifted():
    """Return the skeleton of a drifted walk, and which tracks are the same points."""
    rng = np.random.default_rng(0)
    places = [
        true_pose(n).transform(rng.uniform([-1, -1, 2], [1, 1, 4], (30, 3))) for n in range(A_ROUND)
    ]
    views, points = [], []
    for n in range(KEYFRAMES - SEEN_FOR + 1):
        for p in places[n % A_ROUND]:
            track = len(points)
            points.append(drift(n).transform(p))
            for k in range(n, n + SEEN_FOR):
                in_cam = true_pose(k).inverse().transform(p)
                views.append((k, track, *(in_cam[:2] / in_cam[2])))
    table = np.array(sorted(views))
    structure = Structure(
        keyframe=table[:, 0].astype(int), track=table[:, 1].astype(int), flat=table[:, 2:],
        focal_px=FOCAL_PX,
    )  # fmt: skip
    structure.points_map[:], structure.has_point[:] = points, True
    for k in range(KEYFRAMES):
        T = drift(k).transform_pose(true_pose(k)).inverse()
        structure.set_pose(k, T.R, T.t)
    return Skeleton(
        structure=structure, frames=np.arange(KEYFRAMES), track_of=np.arange(len(points)),
        uv_px=table[:, 2:] * FOCAL_PX,
    )  # fmt: skip


def loop_at(structure, k):
    """Return the loop of a keyframe that sees what keyframe k - A_ROUND saw first."""
    views = structure.views(k)
    rows = np.arange(views.start, views.stop)
    first_place = structure.track[rows] // 30
    again = first_place >= A_ROUND
    back = drift(k).inverse()
    old = drift(k - A_ROUND)
    S = Similarity(scale=old.scale * back.scale, R=old.R @ back.R, t=old.transform(back.t))
    return Loop(
        keyframe=k, old_keyframe=k - A_ROUND, S_old_present=S, rows=rows[again],
        tracks=structure.track[rows[again]] - 30 * A_ROUND, drift_px=50.0,
    )  # fmt: skip


def centre_error(structure):
    R, t = structure.R_cam_map, structure.t_cam_map
    centres = -np.einsum("kji,kj->ki", R, t)
    true = np.array([true_pose(k).t for k in range(KEYFRAMES)])
    S = fit_similarity(centres, true)
    return float(np.sqrt(((S.transform(centres) - true) ** 2).sum(axis=1).mean()))


def test_a_bent_map_meets_where_it_shows_the_same_place(drifted):
    structure = drifted.structure
    before = centre_error(structure)
    loops = [loop_at(structure, k) for k in (45, 47)]
    bend(structure, loops)
    merge_tracks(drifted, loops)
    structure.adjust(cauchy_px=2.0)
    assert before > 0.01
    assert centre_error(structure) < 0.05 * before


def test_merged_tracks_are_one_and_no_keyframe_sees_a_track_twice(drifted):
    structure = drifted.structure
    loop = loop_at(structure, 47)
    merge_tracks(drifted, [loop])
    assert len(loop.rows) >= 60
    assert (structure.track[loop.rows] == loop.tracks).all()
    assert not structure.has_point[loop.tracks + 30 * A_ROUND].any()
    pairs = np.column_stack([structure.keyframe, structure.track])
    assert len(np.unique(pairs, axis=0)) == len(pairs)


def test_a_loop_that_no_other_keyframe_confirms_is_left_out(drifted):
    structure = drifted.structure
    first, second = loop_at(structure, 45), loop_at(structure, 47)
    wrong = Loop(
        keyframe=46, old_keyframe=10, S_old_present=Similarity.identity(), rows=first.rows,
        tracks=first.tracks, drift_px=50.0,
    )  # fmt: skip
    kept = agreeing(structure, [first, wrong, second])
    assert first in kept
    assert second in kept
    assert agreeing(structure, [first]) == []
