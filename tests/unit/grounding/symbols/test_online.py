import numpy as np
import pytest

from grounding.errors import InputError
from grounding.features.registry import PatchFeatures
from grounding.symbols.classify import Classifier
from grounding.symbols.document import from_json, to_json
from grounding.symbols.learn import fit_symbols
from grounding.symbols.model import SymbolModel
from grounding.symbols.online import forget, update
from grounding.symbols.records import LabelledPatch, Mode, SymbolConfig
from grounding.symbols.simulated import Scene, Shape, Thing
from tests.patches import Trained, features_of, share_right

Things = list[tuple[str, str, PatchFeatures]]
TOLERANCE = 0.05  # of a word's spread: what docs/symbols.md states


@pytest.fixture(scope="module")
def grown(trained: Trained) -> SymbolModel:
    """Return a model of the first half that learnt the second half patch by patch."""
    half = len(trained.patches) // 2
    model = fit_symbols(trained.patches[:half], SymbolConfig())
    for patch in trained.patches[half:]:
        model = update(model, patch)
    return model


def test_learning_on_gives_what_a_fit_of_all_gives(grown: SymbolModel, model: SymbolModel):
    assert set(grown.words) == set(model.words)
    for name, word in model.words.items():
        group = model.group_of(name)
        assert group is not None
        columns = model.columns(group.features)
        variance = np.diag(word.moments.scatter)[columns] / word.moments.weight
        apart = grown.words[name].moments.mean[columns] - word.moments.mean[columns]
        assert np.abs(apart / np.sqrt(variance + 1)).max() < TOLERANCE, name


def test_both_name_things_alike(grown: SymbolModel, model: SymbolModel, things: Things):
    one, other = share_right(grown, things), share_right(model, things)
    assert all(abs(one[key] - other[key]) < 0.05 for key in one)


def test_a_model_does_not_grow_with_the_patches_seen(model: SymbolModel, trained: Trained):
    sizes = []
    for turn in range(3):
        for patch in trained.patches:
            again = LabelledPatch(
                features=patch.features, symbols=patch.symbols, segment=f"{patch.segment}.{turn}"
            )
            model = update(model, again)
        sizes.append(len(to_json(model)))
    assert sizes[2] < 1.05 * sizes[1]


def test_a_wrong_segment_changes_its_word_little(model: SymbolModel):
    rng = np.random.default_rng(0)
    before = model.words["red"].moments
    for _ in range(8):
        blue = features_of(Thing(colour="blue", shape=Shape.CUBE), Scene(), rng)
        model = update(model, LabelledPatch(features=blue, symbols=("red",), segment="wrong"))
    after = model.words["red"].moments
    assert np.abs(after.mean - before.mean).max() < 0.05
    assert model.words["red"].dropped > 0


def test_a_word_that_was_forgotten_is_gone(model: SymbolModel):
    without = forget(model, "red")
    assert "red" not in without.words
    assert without.group_named("colour").words == ("blue", "yellow")
    with pytest.raises(InputError, match="no word 'red'"):
        forget(without, "red")


def test_a_model_goes_on_learning_after_it_was_read_back(grown: SymbolModel, trained: Trained):
    read = from_json(to_json(grown), where="model.json")
    one, other = update(grown, trained.patches[0]), update(read, trained.patches[0])
    for name in one.words:
        assert np.allclose(one.words[name].moments.mean, other.words[name].moments.mean)


def test_paper_mode_does_not_learn_on(trained: Trained):
    paper = fit_symbols(trained.patches[:60], SymbolConfig(mode=Mode.PAPER))
    with pytest.raises(InputError, match="paper"):
        update(paper, trained.patches[0])


def test_a_new_word_joins_the_group_that_is_at_a_loss(model: SymbolModel):
    rng = np.random.default_rng(1)
    for number in range(3):
        green = features_of(Thing(colour="green", shape=Shape.CUBE), Scene(), rng)
        patch = LabelledPatch(features=green, symbols=("green", "cube"), segment=f"g{number}")
        model = update(model, patch)
    assert "green" in model.group_named("colour").words
    found = Classifier(model).classify(
        features_of(Thing(colour="green", shape=Shape.CELL), Scene(), rng)
    )
    assert {"green", "cell"} <= {each.symbol for each in found if each.known}
