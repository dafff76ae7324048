"""From the first views to all keyframes: pose the best-seen next one, triangulate, adjust."""

import logging

import numpy as np

from gazemap.errors import SolverError
from gazemap.slam.config import SlamConfig
from gazemap.slam.structure import Structure

_log = logging.getLogger(__name__)

_GROWTH_BETWEEN_ADJUSTMENTS = 1.5
_QUICK_ITERATIONS = 10


def grow(structure: Structure, config: SlamConfig) -> None:
    """Pose as many keyframes as the tracks reach, and adjust the whole."""
    posed_count = -1
    # A better map may pose keyframes that were refused before.
    while structure.is_posed.sum() > posed_count:
        posed_count = int(structure.is_posed.sum())
        _extend(structure, config)
        _settle(structure, config)
    _settle(structure, config)


def _extend(structure: Structure, config: SlamConfig) -> None:
    """Pose keyframes one after the other, the one that sees most of the map first."""
    _triangulate(structure, config)
    refused = np.zeros(len(structure.is_posed), dtype=np.bool_)
    next_adjustment = _GROWTH_BETWEEN_ADJUSTMENTS * structure.is_posed.sum()
    while True:
        counts = structure.known_counts()
        counts[structure.is_posed | refused] = 0
        k = int(counts.argmax())
        if counts[k] < config.min_inliers:
            return
        if not structure.locate(k, min_inliers=config.min_inliers):
            refused[k] = True
            continue
        _triangulate(structure, config)
        if structure.is_posed.sum() >= next_adjustment:
            _settle(structure, config)
            next_adjustment = _GROWTH_BETWEEN_ADJUSTMENTS * structure.is_posed.sum()


def _settle(structure: Structure, config: SlamConfig) -> None:
    try:
        structure.adjust(cauchy_px=config.bundle_cauchy_px, iterations=_QUICK_ITERATIONS)
    except SolverError as error:
        # The map is as it was before; more keyframes may hold it better.
        _log.warning("%s with %d keyframes", error, structure.is_posed.sum())
    _triangulate(structure, config)


def _triangulate(structure: Structure, config: SlamConfig) -> None:
    structure.triangulate(min_parallax_rad=float(np.radians(config.min_parallax_deg)))
