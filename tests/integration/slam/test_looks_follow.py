"""Looks that were published follow the map that they were made in, however it is corrected."""

from dataclasses import replace

import numpy as np
import pytest

from gazemap.geometry.align import fit_similarity_of_poses
from gazemap.live import LiveMapping, LiveMappingConfig, LiveRig
from gazemap.slam.live.config import LiveConfig
from gazemap.types.frame import Frame
from gazemap.types.map import MapEventKind
from gazemap.types.session import Fixation
from gazemap.types.tracking import Tracked
from tests.planes import CAMERA, FRAME_NS, draw, hall, ring, swaying, turning

BLANK = np.full((CAMERA.height_px, CAMERA.width_px), 90, np.uint8)
TRACKING = LiveConfig(in_process=True, lag_frames=3)


def watched(images, looks, *, camera=CAMERA, tracking=TRACKING):
    """Return outcomes, events and where the looks at these frames are thought to be from.

    The poses of the looks are returned as they were right after the last frame before the event
    that moved them, and as they are in the end.
    """
    rig = LiveRig(head_camera=camera, overhead_camera=None, layout=None)
    config = LiveMappingConfig(tracking=tracking)
    outcomes, events, before = [], [], {}
    with LiveMapping(rig, config, rng=np.random.default_rng(0)) as mapping:
        for n, image in enumerate(images):
            if n in looks:
                t_ns = n * FRAME_NS
                mapping.device_fixation(
                    Fixation(fixation_id=n, start_ns=t_ns, end_ns=t_ns, u_px=200.0, v_px=150.0)
                )
            now = poses_of(mapping)
            news = mapping.head_frame(Frame(index=n, t_ns=n * FRAME_NS, image=image))
            outcomes.append(news.outcome)
            if any(e.S_new_old is not None for e in news.events):
                before = now
            events.extend(news.events)
        return outcomes, events, before, poses_of(mapping)


def poses_of(mapping):
    return {key: look.T_world_cam for key, look in mapping.looks._looks.items()}


def errors_m(found, poses, S):
    return {n: np.linalg.norm(S.transform(T.t) - poses[n].t) for n, T in found.items()}


def world_of(outcomes, poses):
    """Return what takes the map's world into the drawn one, by the first map's poses."""
    pairs = [
        (o.T_world_cam, T) for o, T in zip(outcomes, poses, strict=True) if isinstance(o, Tracked)
    ]
    return fit_similarity_of_poses([a for a, _ in pairs], [b for _, b in pairs])


@pytest.fixture(scope="module")
def merged():
    """Carried blindly to another table and back: two maps become one."""
    away = np.concatenate([np.full(45, 2.0), np.linspace(2.0, 0.0, 100), np.zeros(25)])
    poses = swaying(60)
    poses += [
        replace(T, t=T.t + np.array([x, 0, 0]))
        for T, x in zip(swaying(170, phase=2.0), away, strict=True)
    ]
    images = [draw(hall(), T) for T in poses]
    images[60:66] = [BLANK] * 6
    tracking = replace(TRACKING, new_map_after_s=0.3)
    return poses, watched(images, {30, 50, 110, 140, 170, 225}, tracking=tracking)


def test_looks_of_a_merged_map_move_and_those_of_the_other_stay(merged):
    poses, (outcomes, events, before, after) = merged
    assert [e.kind for e in events if e.S_new_old is not None] == [MapEventKind.MERGED]
    S = world_of(outcomes[:60], poses[:60])
    errors, wrong = errors_m(after, poses, S), errors_m(before, poses, S)
    assert min(wrong[n] for n in (110, 140, 170)) > 0.1
    assert 1e-6 < max(errors.values()) < 0.03
    for n in (30, 50):
        assert np.linalg.norm(after[n].t - before[n].t) < 0.01


@pytest.mark.slow
def test_looks_all_around_a_loop_move_each_with_its_part():
    """A focal length that is 4 % off opens a loop; the further round, the more a look moves."""
    poses = turning(380, per_turn=300)
    wrong = replace(CAMERA, K=CAMERA.K * [[0.96, 1, 1], [1, 0.96, 1], [1, 1, 1]])
    images = []
    for T in poses:
        far_first = sorted(ring(), key=lambda w: -np.linalg.norm(w.corner + w.x / 2 - T.t))
        images.append(draw(far_first, T))
    looks = {40, 80, 160, 240, 280, 340}
    outcomes, events, before, after = watched(images, looks, camera=wrong)
    assert [e.kind for e in events if e.S_new_old is not None] == [MapEventKind.LOOP_CLOSED]
    S = world_of(outcomes[:100], poses[:100])
    errors, opened = errors_m(after, poses, S), errors_m(before, poses, S)
    assert opened[340] > 0.1
    assert 1e-6 < errors[340] < 0.5 * opened[340]
    # What the event says is how the latest keyframe's surroundings moved: the beginning stays.
    assert errors[40] < 0.07
    ends = [
        fit_similarity_of_poses(list(x.values()), [poses[n] for n in x]) for x in (before, after)
    ]
    bent = [max(errors_m(x, poses, S).values()) for x, S in zip((before, after), ends, strict=True)]
    assert bent[1] < 0.7 * bent[0]
