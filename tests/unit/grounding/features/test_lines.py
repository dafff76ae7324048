import numpy as np

from grounding.features.lines import line_distances


def test_shade_is_no_distance_and_another_hue_is():
    line = np.array([[100.0, 120.0, 160.0, 0.5, 1.2, 0.0, 1.0]])
    pixels = np.array([[50, 60, 80], [120, 144, 192], [100, 120, 160], [160, 120, 100]], np.float32)
    found = line_distances(pixels, line)
    assert np.allclose(found[:3], 0, atol=1e-4)
    assert 60 < found[3] < 85  # up to the nearest point of the line, not of the colour


def test_beyond_the_stretch_the_rest_counts():
    line = np.array([[100.0, 100.0, 100.0, 0.5, 1.2, 0.0, 2.0]])
    dark = np.array([[20, 20, 20]], np.float32)
    assert np.isclose(line_distances(dark, line)[0], 30 * np.sqrt(3) / 2)


def test_the_nearest_of_several_lines_counts_and_no_pixel_is_no_error():
    lines = np.array([[200.0, 0, 0, 0.5, 1.0, 0.0, 1.0], [0, 0, 200.0, 0.5, 1.0, 0.0, 1.0]])
    pixels = np.array([[150, 0, 3], [4, 0, 150]], np.float32)
    assert np.allclose(line_distances(pixels, lines), [3, 4])
    assert line_distances(np.empty((0, 3), np.float32), lines).shape == (0,)
