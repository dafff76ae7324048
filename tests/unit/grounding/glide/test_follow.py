import dataclasses

import numpy as np

from grounding.glide.config import GlideConfig
from grounding.glide.follow import Follower
from grounding.glide.model import Demonstration
from grounding.glide.windows import align_session
from services.bench.glide import Scene, SceneConfig, draw_scene

CONFIG = GlideConfig(live_window=6)


def drawn() -> Scene:
    config = SceneConfig(pairs=8, motion=True, times=True, sigma_m=0.01)
    return draw_scene(config, np.random.default_rng(5))


def until(demonstration: Demonstration, end_ns: int) -> Demonstration:
    """What was said, looked at and seen by then."""
    objects = [
        dataclasses.replace(
            each,
            track=tuple(
                dataclasses.replace(
                    r, left_ns=r.left_ns if r.left_ns and r.left_ns <= end_ns else None
                )
                for r in each.track
                if r.t_ns <= end_ns
            ),
        )
        for each in demonstration.objects
    ]
    return dataclasses.replace(
        demonstration,
        spoken=[s for s in demonstration.spoken if (s.said_start_ns or 0) <= end_ns],
        fixations=[f for f in demonstration.fixations if f.end_ns <= end_ns],
        objects=objects,
    )


def followed(scene: Scene, follower: Follower) -> list[tuple[int, int]]:
    """Follow a session in steps of 5 s; how many instructions were open at each, and were said."""
    last = max(f.end_ns for f in scene.demonstration.fixations)
    open_ones = []
    for end_ns in range(int(5e9), last + int(5e9), int(5e9)):
        so_far = until(scene.demonstration, end_ns)
        settled = len(follower._settled.spoken)
        alignment = follower.align(so_far, CONFIG)
        assert [x.index for x in alignment.instructions] == [s.index for s in so_far.spoken]
        assert [x.fixation_id for x in alignment.looks] == [f.fixation_id for f in so_far.fixations]
        open_ones.append((len(so_far.spoken) - settled, len(so_far.spoken)))
    return open_ones


def test_an_update_costs_what_the_last_instructions_cost() -> None:
    open_ones = followed(drawn(), Follower())
    assert max(count for count, _ in open_ones) <= CONFIG.live_window + 4
    assert open_ones[-1][1] == 16


def test_what_was_followed_ends_as_the_whole_session_aligned_at_once() -> None:
    scene, follower = drawn(), Follower()
    followed(scene, follower)
    live = follower.align(scene.demonstration, CONFIG)
    whole = align_session(scene.demonstration)
    for one, other in zip(live.instructions, whole.instructions, strict=True):
        assert one.candidates[0].object_id == other.candidates[0].object_id
    labels = zip(live.looks, whole.looks, strict=True)
    assert np.mean([a.instruction == b.instruction for a, b in labels]) > 0.97


def test_a_correction_of_what_is_settled_is_heeded() -> None:
    scene, follower = drawn(), Follower()
    followed(scene, follower)
    assert follower._settled.spoken
    others = {o.object_id for o in scene.demonstration.objects} - set(scene.things[:2])
    told = dataclasses.replace(scene.demonstration, not_meant={0: frozenset({scene.things[0]})})
    first = follower.align(told, CONFIG).instructions[0]
    assert {c.object_id for c in first.candidates} <= others | {None}
