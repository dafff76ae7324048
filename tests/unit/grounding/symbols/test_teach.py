import numpy as np
import pytest

from grounding.errors import InputError
from grounding.features.registry import PatchFeatures, extract_features
from grounding.symbols.classify import Classifier, classify
from grounding.symbols.model import SymbolModel
from grounding.symbols.simulated import Scene, Shape, Thing, draw_patch
from grounding.symbols.teach import Taught, WhichGroup, questions, teach
from tests.patches import features_of, share_right

Things = list[tuple[str, str, PatchFeatures]]


def seen(colour: str, shape: Shape, count: int, seed: int) -> list[PatchFeatures]:
    rng = np.random.default_rng(seed)
    return [features_of(Thing(colour=colour, shape=shape), Scene(), rng) for _ in range(count)]


@pytest.mark.parametrize("colour", ["green", "cyan", "white"])
def test_three_examples_of_a_colour_are_enough(model: SymbolModel, things: Things, colour: str):
    taught = teach(model, colour, seen(colour, Shape.CUBE, 3, 5))
    assert isinstance(taught, Taught)
    assert taught.group == "colour"
    classifier = Classifier(taught.model)
    named = [
        colour in {each.symbol for each in classifier.classify(features) if each.known}
        for shape in (Shape.CELL, Shape.BLOCK, Shape.DISC)
        for features in seen(colour, shape, 10, 6)
    ]
    assert np.mean(named) >= 0.9
    before, after = share_right(model, things), share_right(taught.model, things)
    assert after["colour", True] >= before["colour", True] - 0.01


def test_a_thing_at_a_loss_raises_one_question(model: SymbolModel):
    green = seen("green", Shape.CUBE, 1, 7)[0]
    asked = questions(model, classify(model, green))
    assert [question.group for question in asked] == ["colour"]
    assert "blue, red, yellow" in asked[0].text


def test_a_known_thing_raises_no_question(model: SymbolModel):
    assert questions(model, classify(model, seen("red", Shape.CUBE, 1, 8)[0])) == ()


def test_examples_that_are_new_in_two_ways_need_a_group(model: SymbolModel):
    green_rings = seen("green", Shape.RING, 3, 9)
    asked = teach(model, "torus", green_rings)
    assert isinstance(asked, WhichGroup)
    assert set(asked.groups) == {"colour", "shape"}
    taught = teach(model, "torus", green_rings, group="shape")
    assert isinstance(taught, Taught)
    red_ring = classify(taught.model, seen("red", Shape.RING, 1, 10)[0])
    assert {"torus", "red"} <= {each.symbol for each in red_ring if each.known}


def test_a_name_for_one_thing_is_a_group_of_its_own(model: SymbolModel):
    taught = teach(model, "mascot", seen("pink", Shape.CROSS, 3, 11), group="new")
    assert isinstance(taught, Taught)
    assert taught.model.group_named("mascot").words == ("mascot",)
    said = {
        each.symbol
        for each in classify(taught.model, seen("pink", Shape.CROSS, 1, 12)[0])
        if each.known
    }
    assert "mascot" in said
    other = classify(taught.model, seen("pink", Shape.CUBE, 1, 12)[0])
    assert "mascot" not in {each.symbol for each in other if each.known}


def test_teaching_nothing_is_refused(model: SymbolModel):
    with pytest.raises(InputError, match="no example"):
        teach(model, "green", [])
    with pytest.raises(InputError, match="no group 'taste'"):
        teach(model, "green", seen("green", Shape.CUBE, 1, 1), group="taste")


def without_scale(colour: str, count: int) -> list[PatchFeatures]:
    rng = np.random.default_rng(9)
    images = [
        draw_patch(Thing(colour=colour, shape=Shape.CUBE), Scene(), rng) for _ in range(count)
    ]
    found = [extract_features(image) for image in images]
    return [each for each in found if isinstance(each, PatchFeatures)]


def test_a_colour_is_taught_without_a_metric_scale(model: SymbolModel):
    # such examples counted as dropped, and nothing was learnt, nor said about it
    taught = teach(model, "green", without_scale("green", 3))
    assert isinstance(taught, Taught)
    assert (taught.group, taught.model.words["green"].kept) == ("colour", 3)
    found = classify(taught.model, seen("green", Shape.BLOCK, 1, 10)[0])
    assert "green" in {each.symbol for each in found if each.known}


def test_a_shape_is_not_asked_for_where_only_the_scale_is_missing(model: SymbolModel):
    asked = questions(model, classify(model, without_scale("green", 1)[0]))
    assert [question.group for question in asked] == ["colour"]


def test_a_shape_is_not_taught_without_a_metric_scale(model: SymbolModel):
    with pytest.raises(InputError, match="mm_per_px"):
        teach(model, "brick", without_scale("red", 3), group="shape")
