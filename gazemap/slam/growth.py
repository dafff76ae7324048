"""From the first views to all keyframes: pose the best-seen next one, triangulate, adjust."""

import numpy as np

from gazemap.slam.config import SlamConfig
from gazemap.slam.structure import Structure

_GROWTH_BETWEEN_ADJUSTMENTS = 1.5


def grow(structure: Structure, config: SlamConfig) -> None:
    """Pose as many keyframes as the tracks reach; bundle-adjust each time they grow by half."""
    min_parallax_rad = float(np.radians(config.min_parallax_deg))
    structure.triangulate(min_parallax_rad=min_parallax_rad)
    adjusted_count = int(structure.is_posed.sum())
    refused = np.zeros(len(structure.is_posed), dtype=np.bool_)
    while True:
        counts = structure.known_counts()
        counts[structure.is_posed | refused] = 0
        k = int(counts.argmax())
        if counts[k] < config.min_inliers:
            if not refused.any() or structure.is_posed.sum() == adjusted_count:
                break
            # More of the map may pose what was refused before.
            refused[:] = False
        elif structure.locate(k, min_inliers=config.min_inliers):
            structure.triangulate(min_parallax_rad=min_parallax_rad)
        else:
            refused[k] = True
            continue
        if (
            structure.is_posed.sum() >= _GROWTH_BETWEEN_ADJUSTMENTS * adjusted_count
            or not counts[k]
        ):
            structure.adjust(cauchy_px=config.bundle_cauchy_px, iterations=15)
            structure.triangulate(min_parallax_rad=min_parallax_rad)
            adjusted_count = int(structure.is_posed.sum())
    finish(structure, config)


def finish(structure: Structure, config: SlamConfig) -> None:
    """Adjust everything twice, with the outliers of the first time left out."""
    for _ in range(2):
        structure.adjust(cauchy_px=config.bundle_cauchy_px)
        structure.triangulate(min_parallax_rad=float(np.radians(config.min_parallax_deg)))
