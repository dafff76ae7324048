import math

import cv2
import mahotas
import numpy as np
import pytest

from grounding.errors import ConfigError
from grounding.features.background import NoObject
from grounding.features.registry import FEATURES, PatchFeatures, extract_features, features_named


def drawn(mask: np.ndarray, bgr: tuple[int, int, int] = (30, 30, 200)) -> np.ndarray:
    image = np.full((*mask.shape, 3), (90, 130, 170), np.uint8)
    image[mask] = bgr
    return image


def rectangle(length: int, width: int, degrees: float = 0.0) -> np.ndarray:
    mask = np.zeros((128, 128), np.uint8)
    corners = cv2.boxPoints(((64.0, 64.0), (length, width), degrees))
    cv2.fillPoly(mask, [np.round(corners).astype(np.int32)], 1)
    return mask > 0


def disc(radius: int) -> np.ndarray:
    y, x = np.mgrid[:128, :128] - 64
    return np.hypot(x, y) <= radius


def measured(mask: np.ndarray, **known: float) -> PatchFeatures:
    features = extract_features(drawn(mask), mask=mask, **known)
    assert isinstance(features, PatchFeatures)
    return features


def test_a_disc_and_a_square_are_told_by_their_circularity():
    assert abs(measured(disc(30))["circularity"] - 1.0) < 0.05
    assert abs(measured(rectangle(50, 50))["circularity"] - math.pi / 4) < 0.04


def test_elongation_is_the_logarithm_of_the_ratio_of_sides():
    assert abs(measured(rectangle(80, 40, 20.0))["elongation"] - math.log(2)) < 0.05


def test_sizes_are_metric_and_unknown_without_a_scale():
    features = measured(rectangle(60, 30), mm_per_px=0.5, height_mm=12.0)
    assert abs(math.exp(features["log length"]) - 30.5) < 1.0
    assert abs(math.exp(features["log width"]) - 15.5) < 1.0
    assert math.exp(features["log height"]) == pytest.approx(12.0)
    assert math.isnan(measured(rectangle(60, 30))["log length"])


def test_a_large_image_is_measured_like_a_small_one():
    mask = rectangle(60, 30)
    large = cv2.resize(mask.astype(np.uint8), (512, 512), interpolation=cv2.INTER_NEAREST) > 0
    one, other = measured(mask, mm_per_px=1.0), measured(large, mm_per_px=0.25)
    for name in ("log length", "log area", "circularity", "elongation"):
        assert abs(one[name] - other[name]) < FEATURES[name].resolution


def test_hue_points_east_for_red_and_north_for_yellow_green():
    red = extract_features(drawn(disc(30), (0, 0, 200)))
    blue = extract_features(drawn(disc(30), (200, 0, 0)))
    assert isinstance(red, PatchFeatures)
    assert isinstance(blue, PatchFeatures)
    assert red["saturation east"] > 0.9
    assert abs(red["saturation north"]) < 0.05
    assert blue["saturation north"] < -0.7


def test_white_balance_undoes_a_tinted_light():
    plain = extract_features(drawn(disc(30), (60, 120, 200)))
    tinted = extract_features(drawn(disc(30), (48, 120, 200)), white_bgr=(204.0, 255.0, 255.0))
    assert isinstance(plain, PatchFeatures)
    assert isinstance(tinted, PatchFeatures)
    assert abs(plain["lab b"] - tinted["lab b"]) < 1.0


def test_shade_and_highlight_are_left_out_of_the_colour():
    image = drawn(rectangle(60, 60), (30, 30, 200))
    image[80:94, 34:94] = (12, 12, 80)
    image[40:44, 40:44] = 255
    features = extract_features(image, mask=rectangle(60, 60))
    plain = extract_features(drawn(rectangle(60, 60), (30, 30, 200)))
    assert isinstance(features, PatchFeatures)
    assert isinstance(plain, PatchFeatures)
    assert abs(features["lightness"] - plain["lightness"]) < 1.0


@pytest.mark.parametrize("degrees", [10.0, 33.0, 45.0, 80.0])
def test_shape_features_do_not_change_with_rotation(degrees: float):
    upright, turned = measured(rectangle(64, 32)), measured(rectangle(64, 32, degrees))
    for feature in FEATURES.values():
        if feature.family == "shape":
            difference = abs(upright[feature.name] - turned[feature.name])
            assert difference < 2 * feature.resolution, feature.name


def test_zernike_moments_are_those_of_mahotas_times_pi():
    mask = rectangle(64, 32, 20.0)
    theirs = mahotas.features.zernike_moments(mask.astype(np.uint8), 36.5, degree=4)
    ours = [measured(mask)[f"zernike {n},{m}"] for n, m in ((2, 0), (2, 2), (4, 0), (4, 2), (4, 4))]
    assert np.abs(np.array(ours) - math.pi * theirs[[2, 3, 6, 7, 8]]).max() < 0.1


def test_an_unknown_feature_is_refused_by_name():
    with pytest.raises(ConfigError, match="smell"):
        features_named(("red", "smell"))


def test_a_bare_table_has_no_features():
    assert isinstance(extract_features(np.full((64, 64, 3), 120, np.uint8)), NoObject)
