import dataclasses

import numpy as np

from grounding.glide.chance import beyond_chance
from grounding.glide.config import GlideConfig
from services.bench.glide import SceneConfig, draw_scene


def drawn(seed: int, *, motion: bool):
    config = SceneConfig(sigma_m=0.02, outliers=0.2, motion=motion, times=motion)
    return draw_scene(config, np.random.default_rng(seed)).demonstration


def test_a_gaze_that_belongs_to_the_narration_is_far_beyond_chance() -> None:
    for motion in (False, True):
        assert 5.0 < beyond_chance(drawn(1, motion=motion), GlideConfig()) < 80.0


def test_looks_in_disorder_are_not() -> None:
    demonstration = drawn(1, motion=True)
    looks = demonstration.fixations
    order = np.random.default_rng(3).permutation(len(looks))
    mixed = [
        dataclasses.replace(each, point_world=looks[k].point_world, cov_world=looks[k].cov_world)
        for each, k in zip(looks, order, strict=True)
    ]
    shuffled = dataclasses.replace(demonstration, fixations=mixed)
    assert -5.0 < beyond_chance(shuffled, GlideConfig()) < 5.0
