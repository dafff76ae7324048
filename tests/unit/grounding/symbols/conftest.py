"""A training set, its model, and things to name: made once a run."""

import pytest

from grounding.features.registry import PatchFeatures
from grounding.symbols.learn import fit_symbols
from grounding.symbols.model import SymbolModel
from grounding.symbols.records import SymbolConfig
from grounding.symbols.simulated import Scene
from tests.patches import Trained, things_to_name, training_set


@pytest.fixture(scope="session")
def trained() -> Trained:
    """Return 48 segments of 6 patches on wood, every fourth labelled wrong."""
    return training_set(Scene(), seed=1, segments=48, patches=6)


@pytest.fixture(scope="session")
def model(trained: Trained) -> SymbolModel:
    """Return what is learnt from them."""
    return fit_symbols(trained.patches, SymbolConfig())


@pytest.fixture(scope="session")
def things() -> list[tuple[str, str, PatchFeatures]]:
    """Return things on the same table that were not trained on."""
    return list(things_to_name(Scene(), seed=2, rounds=6))
