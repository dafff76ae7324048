"""Whether the gaze goes with the narration: its evidence beside that of looks in disorder."""

import dataclasses
from typing import Final

import numpy as np

from grounding.glide.align import align
from grounding.glide.config import GlideConfig, Inference
from grounding.glide.model import Demonstration
from grounding.glide.windows import first_window

_DISORDERS: Final = 6
_ROUNDS: Final = 1


def beyond_chance(demonstration: Demonstration, config: GlideConfig) -> float:
    """Return by how many standard deviations the evidence exceeds that of looks in disorder.

    The looks keep their times and exchange what they met: what vision saw move and what was said
    when stay as they are, so that only what the gaze adds is compared. Of a long session the first
    window speaks for all.
    """
    quick = dataclasses.replace(config, rounds=_ROUNDS, inference=Inference.EXACT)
    demonstration = first_window(demonstration, config)
    rng = np.random.default_rng(0)
    evidence = align(demonstration, quick).log_evidence
    chance = [
        align(_in_disorder(demonstration, rng), quick).log_evidence for _ in range(_DISORDERS)
    ]
    return float((evidence - np.mean(chance)) / max(float(np.std(chance, ddof=1)), 1.0))


def _in_disorder(demonstration: Demonstration, rng: np.random.Generator) -> Demonstration:
    looks = demonstration.fixations
    fixations = [
        dataclasses.replace(
            each,
            point_world=looks[k].point_world,
            cov_world=looks[k].cov_world,
            origin_world=looks[k].origin_world,
        )
        for each, k in zip(looks, rng.permutation(len(looks)), strict=True)
    ]
    return dataclasses.replace(demonstration, fixations=fixations)
