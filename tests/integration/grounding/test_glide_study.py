"""Drawn scenes of growing noise: exact inference beside the paper's sampling (docs/glide.md, 9)."""

import numpy as np
import pytest

from grounding.glide.align import Alignment, align
from grounding.glide.config import GlideConfig, Inference
from services.bench.glide import Scene, SceneConfig, draw_scene

EXACT = GlideConfig()
SAMPLED = GlideConfig(inference=Inference.DIRICHLET, rounds=2)
CELLS = [(sigma, outliers) for sigma in (0.01, 0.02, 0.03) for outliers in (0.1, 0.2, 0.3)]


def figures(scene: Scene, alignment: Alignment) -> tuple[float, float, float]:
    """Purity of the labels, share of all looks labelled right, share of targets found."""
    pairs = list(zip((x.instruction for x in alignment.looks), scene.labels, strict=True))
    targets = zip(
        (x.candidates[0].object_id for x in alignment.instructions), scene.things, strict=True
    )
    return (
        float(np.mean([said == true for said, true in pairs if said is not None])),
        float(np.mean([said == true for said, true in pairs])),
        float(np.mean([found == true for found, true in targets])),
    )


def study(sigma_m: float, outliers: float, config: GlideConfig, *, scenes: int) -> np.ndarray:
    drawn = (
        draw_scene(SceneConfig(sigma_m=sigma_m, outliers=outliers), np.random.default_rng(seed))
        for seed in range(scenes)
    )
    rng = np.random.default_rng(0)
    rows = [figures(scene, align(scene.demonstration, config, rng=rng)) for scene in drawn]
    return np.mean(rows, axis=0)


@pytest.mark.parametrize(("sigma_m", "outliers"), [CELLS[0], CELLS[4]])
def test_exact_inference_finds_targets_and_labels(sigma_m: float, outliers: float) -> None:
    purity, right, found = study(sigma_m, outliers, EXACT, scenes=10)
    assert 0.9 < purity < 0.999
    assert 0.85 < right < 0.999
    assert found >= 0.95


@pytest.mark.slow
@pytest.mark.parametrize(("sigma_m", "outliers"), CELLS)
def test_exact_labels_more_looks_right_than_sampling(sigma_m: float, outliers: float) -> None:
    exact = study(sigma_m, outliers, EXACT, scenes=100)
    sampled = study(sigma_m, outliers, SAMPLED, scenes=100)
    assert exact[1] > sampled[1]
    assert exact[0] > sampled[0] - 0.03
