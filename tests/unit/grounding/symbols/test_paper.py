import numpy as np

from grounding.features.registry import FEATURES, PatchFeatures
from grounding.symbols.classify import classify
from grounding.symbols.learn import fit_symbols
from grounding.symbols.records import LabelledPatch, Mode, SymbolConfig

CONFIG = SymbolConfig(mode=Mode.PAPER)


def patch(red: float, area: float, *words: str) -> LabelledPatch:
    given = {"red": red, "green": 0.0, "blue": 0.0, "pixel area": area}
    values = np.array([given.get(name, 0.0) for name in FEATURES])
    return LabelledPatch(
        features=PatchFeatures(names=tuple(FEATURES), values=values), symbols=words, segment="s"
    )


def patches() -> list[LabelledPatch]:
    """Dark and bright things, small and large ones, each word with one feature in common."""
    made = []
    for step in range(11):
        jitter = (step - 5) / 5
        made += [
            patch(20 + jitter, 100 + jitter, "dark", "small"),
            patch(20 + jitter, 900 + jitter, "dark", "large"),
            patch(220 + jitter, 100 + jitter, "bright", "small"),
            patch(220 + jitter, 900 + jitter, "bright", "large"),
        ]
    return made


def features(red: float, area: float) -> PatchFeatures:
    made = patch(red, area).features
    assert isinstance(made, PatchFeatures)
    return made


def test_words_with_the_same_invariant_features_form_a_group():
    groups = {group.words: group.features for group in fit_symbols(patches(), CONFIG).groups}
    assert groups == {
        ("bright", "dark"): ("red", "green", "blue"),
        ("large", "small"): ("green", "blue", "pixel area"),
    }


def test_features_are_scaled_to_one():
    model = fit_symbols(patches(), CONFIG)
    assert model.offset[0] == 19.0
    assert model.unit[0] == 202.0


def test_samples_beyond_two_sigma_are_dropped():
    spoilt = [*patches(), *(patch(220, 500, "dark") for _ in range(2))]
    model = fit_symbols(spoilt, CONFIG)
    assert (model.words["dark"].kept, model.words["dark"].dropped) == (22, 2)
    mean = model.words["dark"].moments.mean[0] * model.unit[0] + model.offset[0]
    assert abs(mean - 20.0) < 1e-9


def test_the_densest_word_is_said_and_a_far_thing_is_unknown():
    model = fit_symbols(patches(), CONFIG)
    near = {each.symbol: each.known for each in classify(model, features(20.4, 900.2))}
    assert near == {"dark": True, "large": True}
    far = classify(model, features(120, 500))
    assert not any(each.known for each in far)
