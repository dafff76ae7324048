import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from grounding.symbols.calibration import Calibration, with_one_more
from grounding.symbols.model import Moments

SAMPLES = arrays(np.float64, (7, 3), elements=st.floats(-50, 50))
WEIGHTS = arrays(np.float64, (7,), elements=st.floats(0.1, 2))


def moments(samples: np.ndarray, weights: np.ndarray) -> Moments:
    return Moments.of(samples, weights, effective=float(weights.sum()))


def assert_same(one: Moments, other: Moments) -> None:
    assert np.isclose(one.weight, other.weight)
    assert np.allclose(one.mean, other.mean, atol=1e-6)
    assert np.allclose(one.scatter, other.scatter, atol=1e-5)


@given(samples=SAMPLES, weights=WEIGHTS, cut=st.integers(1, 6))
def test_two_parts_add_up_to_the_whole(samples: np.ndarray, weights: np.ndarray, cut: int):
    parts = moments(samples[:cut], weights[:cut]).plus(moments(samples[cut:], weights[cut:]))
    assert_same(parts, moments(samples, weights))


@given(samples=SAMPLES, weights=WEIGHTS, cut=st.integers(1, 6))
def test_what_is_taken_back_leaves_the_rest(samples: np.ndarray, weights: np.ndarray, cut: int):
    rest = moments(samples, weights).plus(moments(samples[cut:], weights[cut:]).scaled(-1.0))
    assert_same(rest, moments(samples[:cut], weights[:cut]))


@given(samples=SAMPLES, weights=WEIGHTS, order=st.permutations(range(7)))
def test_the_order_of_patches_does_not_matter(
    samples: np.ndarray, weights: np.ndarray, order: list[int]
):
    one_by_one = Moments.none(3)
    for place in order:
        one_by_one = one_by_one.plus(Moments.single(samples[place], float(weights[place])))
    assert_same(one_by_one, moments(samples, weights))


@given(
    known=st.lists(st.floats(0.1, 20), min_size=1, max_size=80),
    distances=st.lists(st.floats(0, 60), min_size=2, max_size=10),
)
def test_what_lies_farther_is_never_more_typical(known: list[float], distances: list[float]):
    calibration = Calibration.of(np.sort(known), dimension=4)
    p = np.array([calibration.p_value(distance) for distance in sorted(distances)])
    assert (np.diff(p) <= 1e-12).all()
    assert ((p >= 0) & (p <= 1)).all()


@given(known=st.lists(st.floats(0, 20), min_size=1, max_size=30), new=st.floats(0, 20))
def test_distances_stay_sorted(known: list[float], new: float):
    grown = with_one_more(np.sort(known), new, 3)
    assert (np.diff(grown) >= 0).all()
    assert new in grown
