import json

import numpy as np
import pytest

from grounding.errors import InputError
from grounding.symbols.learn import fit_symbols
from grounding.symbols.lexicon import call, exported, merged, understand
from grounding.symbols.model import SymbolModel
from grounding.symbols.records import SymbolConfig
from grounding.symbols.teach import Taught, teach
from tests.patches import Trained, relabelled


def test_a_persons_own_word_is_theirs_alone(model: SymbolModel):
    known = call(model, "mustard", "yellow", person="ann")
    assert understand(known, "mustard", person="ann") == "yellow"
    assert understand(known, "mustard", person="bob") is None
    assert json.loads(exported(known, person="ann")) == {"mustard": "yellow"}


def test_everyones_word_is_understood_from_all(model: SymbolModel):
    known = call(model, "crimson", "red")
    assert understand(known, "crimson", person="bob") == "red"


def test_an_unseen_compound_means_what_its_head_does(model: SymbolModel):
    assert understand(model, "steak-cube") == "cube"
    assert understand(model, "steak") is None


def test_a_learnt_word_is_not_renamed(model: SymbolModel):
    with pytest.raises(InputError, match="meaning of its own"):
        call(model, "red", "yellow")
    with pytest.raises(InputError, match="no word 'ocre'"):
        call(model, "mustard", "ocre")


def test_merging_adds_what_both_know(trained: Trained, model: SymbolModel):
    half = len(trained.patches) // 2
    one = fit_symbols(trained.patches[:half], SymbolConfig())
    other = call(fit_symbols(trained.patches[half:], SymbolConfig()), "ruby", "red", person="ann")
    both = merged(one, other)
    assert both.words["red"].kept == one.words["red"].kept + other.words["red"].kept
    assert both.lexicons["ann"] == {"ruby": "red"}
    apart = both.words["red"].moments.mean - model.words["red"].moments.mean
    assert np.abs(apart).max() < 0.3


def test_a_word_that_only_one_knows_joins_its_companions(trained: Trained):
    renamed = [relabelled(patch, "red", "crimson") for patch in trained.patches]
    one = fit_symbols(trained.patches, SymbolConfig())
    both = merged(one, fit_symbols(renamed, SymbolConfig()))
    assert both.group_named("colour").words == ("blue", "crimson", "red", "yellow")


def test_merging_with_a_copy_counts_nothing_twice(trained: Trained, model: SymbolModel):
    """Somebody takes a copy, learns one more word, and gives it back."""
    green = [relabelled(p, "red", "green") for p in trained.patches if "red" in p.symbols][:3]
    taught = teach(model, "green", [p.features for p in green], group="colour")
    assert isinstance(taught, Taught)
    for both in (merged(model, taught.model), merged(taught.model, model)):
        assert both.words.keys() == model.words.keys() | {"green"}
        for word in model.words:
            assert both.words[word].kept == model.words[word].kept
            assert both.words[word].moments.weight == model.words[word].moments.weight
        assert both.anything.weight == taught.model.anything.weight
        assert "green" in both.group_named("colour").words
    itself = merged(model, model)
    assert itself.words == model.words
    assert itself.anything.weight == model.anything.weight
