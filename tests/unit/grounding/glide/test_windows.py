import numpy as np
import pytest

from grounding.glide.config import GlideConfig
from grounding.glide.windows import align_session
from services.bench.glide import SceneConfig, draw_scene


@pytest.mark.parametrize("times", [True, False])
def test_a_long_session_is_aligned_in_windows_as_well_as_at_once(*, times: bool) -> None:
    config = SceneConfig(pairs=6, motion=True, times=times, sigma_m=0.01, looks=4)
    scene = draw_scene(config, np.random.default_rng(2))

    def right(glide: GlideConfig) -> tuple[float, float]:
        alignment = align_session(scene.demonstration, glide)
        labels = [each.instruction for each in alignment.looks]
        found = [each.candidates[0].object_id for each in alignment.instructions]
        return (
            float(np.mean([a == b for a, b in zip(labels, scene.labels, strict=True)])),
            float(np.mean([a == b for a, b in zip(found, scene.things, strict=True)])),
        )

    whole, parts = right(GlideConfig()), right(GlideConfig(window=7))
    assert whole[0] >= 0.85
    assert parts[0] >= whole[0] - 0.05
    assert parts[1] >= whole[1] - 0.05
