import cv2
import numpy as np
import pytest

from grounding.features.background import NoObject, NoObjectReason, segment_object
from grounding.symbols.simulated import Scene, Shape, Table, Thing, draw_patch


@pytest.mark.parametrize("table", list(Table))
@pytest.mark.parametrize("noise", [1.0, 6.0])
def test_a_cube_is_found_on_every_table(table: Table, noise: float):
    rng = np.random.default_rng(3)
    for colour in ("red", "blue", "yellow", "green"):
        image = draw_patch(
            Thing(colour=colour, shape=Shape.CUBE), Scene(table=table, noise=noise), rng
        )
        mask = segment_object(image)
        assert not isinstance(mask, NoObject)
        assert 0.9 * 48**2 < np.count_nonzero(mask) < 1.25 * 48**2


@pytest.mark.parametrize("table", list(Table))
def test_a_bare_table_holds_no_object(table: Table):
    rng = np.random.default_rng(4)
    empty = [
        segment_object(draw_patch(None, Scene(table=table, stains=0.3), rng)) for _ in range(12)
    ]
    assert sum(isinstance(each, NoObject) for each in empty) >= 11


@pytest.mark.parametrize(
    ("colour", "table"), [("black", Table.DARK), ("white", Table.LIGHT), ("black", Table.WOOD)]
)
def test_a_thing_that_hardly_stands_out_is_seen(colour: str, table: Table):
    rng = np.random.default_rng(5)
    thing = Thing(colour=colour, shape=Shape.TILE, size=0.7)
    found = [segment_object(draw_patch(thing, Scene(table=table, stains=0), rng)) for _ in range(6)]
    areas = [0 if isinstance(mask, NoObject) else np.count_nonzero(mask) for mask in found]
    assert 0.8 * 61.6**2 < np.median(areas) < 1.3 * 61.6**2


def test_the_hole_of_a_ring_is_table():
    ring = segment_object(
        draw_patch(Thing(colour="blue", shape=Shape.RING), Scene(), np.random.default_rng(1))
    )
    assert not isinstance(ring, NoObject)
    assert not ring[60:68, 60:68].any()


def test_shadow_stays_table():
    image = np.full((96, 96, 3), (90, 130, 170), np.uint8)
    image[30:70, 45:80] = (59, 85, 111)  # the same colour under two thirds of the light
    image[30:70, 30:60] = (40, 40, 200)
    mask = segment_object(image)
    assert not isinstance(mask, NoObject)
    assert abs(int(mask.sum()) - 40 * 30) < 120


def test_a_stain_that_touches_the_object_is_given_back():
    image = np.full((96, 96, 3), (90, 130, 170), np.uint8)
    image[30:62, 30:62] = (190, 80, 40)
    image[40:50, 62:84] = (120, 110, 70)
    mask = segment_object(image)
    assert not isinstance(mask, NoObject)
    assert mask[:, 66:].sum() == 0


@pytest.mark.parametrize(
    ("shape", "reason"),
    [((1, 1, 3), NoObjectReason.TOO_SMALL), ((64, 64, 3), NoObjectReason.ALL_TABLE)],
)
def test_nothing_to_see_has_its_reason(shape: tuple[int, int, int], reason: NoObjectReason):
    assert segment_object(np.full(shape, 77, np.uint8)) == NoObject(reason=reason)


def test_a_thing_at_the_edge_is_not_in_the_middle():
    image = np.full((128, 128, 3), (90, 130, 170), np.uint8)
    image[5:25, 5:25] = (40, 40, 200)
    assert segment_object(image) == NoObject(reason=NoObjectReason.OFF_CENTRE)


def test_another_thing_at_the_rim_of_a_bare_table_is_no_error():
    image = np.full((96, 96, 3), (90, 130, 170), np.uint8)
    image[:, 76:] = (60, 160, 60)
    assert isinstance(segment_object(image), NoObject)


def test_the_top_of_a_black_thing_is_found_beside_its_shadow():
    image = np.full((128, 128, 3), (86, 92, 42), np.uint8)
    image[30:70, 60:90] = (40, 43, 20)
    image[50:84, 46:80] = (28, 28, 30)
    mask = segment_object(cv2.GaussianBlur(image, (3, 3), 0))
    assert not isinstance(mask, NoObject)
    assert 0.93 * 34**2 < np.count_nonzero(mask) < 1.08 * 34**2
