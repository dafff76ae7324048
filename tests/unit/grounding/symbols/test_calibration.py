"""From distances of known things to p-values."""

import numpy as np
import pytest
from scipy.stats import chi2

from grounding.symbols.calibration import Calibration

RATE = 0.001


@pytest.mark.parametrize("dimension", [5, 30])
def test_a_thing_is_unknown_at_like_distances_whatever_the_number_of_features(dimension: int):
    # the model is twice as wide as known things lie, for it counts the resolution twice
    known = np.sqrt(chi2.isf(np.linspace(0.999, 0.001, 400), dimension)) / 2
    calibration = Calibration.of(known, dimension=dimension)
    assert calibration.p_value(2.15 * calibration.start) > RATE
    assert calibration.p_value(2.6 * calibration.start) < RATE
