import numpy as np
import pytest

from gazemap.scene.passing import SeenFrame, arrival_ns, leaving_ns

TABLE, THING, HAND = (120, 130, 140), (80, 200, 160), (160, 140, 145)
PIXELS = np.arange(40, 80)
WITH = np.tile(np.array(THING, dtype=float), (40, 1))


def film(*shown: tuple[int, int, int]) -> list[SeenFrame]:
    frames = []
    for k, colour in enumerate(shown):
        lab = np.tile(np.array(TABLE, dtype=np.uint8), (10, 12, 1))
        lab.reshape(-1, 3)[PIXELS] = colour
        frames.append(SeenFrame(t_ns=k * 100, lab=lab, stands_out=np.zeros((10, 12), dtype=bool)))
    return frames


def test_a_thing_leaves_half_way_through_the_time_it_is_hidden():
    history = film(THING, THING, THING, HAND, HAND, HAND, TABLE, TABLE)
    assert leaving_ns(PIXELS, WITH, history) == pytest.approx(400, abs=1)


def test_a_hand_that_goes_away_again_took_nothing():
    history = film(THING, HAND, HAND, THING, THING, TABLE, TABLE)
    assert leaving_ns(PIXELS, WITH, history) == pytest.approx(450, abs=1)


def test_a_thing_comes_half_way_through_the_time_it_is_hidden():
    history = film(TABLE, TABLE, TABLE, HAND, HAND, HAND, THING, THING)
    assert arrival_ns(PIXELS, WITH, history) == pytest.approx(400, abs=1)


def test_what_was_always_there_has_no_time_of_arrival():
    assert arrival_ns(PIXELS, WITH, film(*[THING] * 8)) is None
