"""Simulated patches for tests: training sets with wrong segments, and things to name."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from grounding.features.registry import PatchFeatures, extract_features
from grounding.symbols.classify import Classifier
from grounding.symbols.model import SymbolModel
from grounding.symbols.records import LabelledPatch
from grounding.symbols.simulated import Scene, Shape, Thing, draw_patch

COLOURS = ("red", "blue", "yellow")
SHAPES = ("cell", "block", "cube")
NEW_COLOURS = ("green", "purple", "cyan", "pink")
NEW_SHAPES = (Shape.PLATE, Shape.RING, Shape.CROSS, Shape.BAR, Shape.COIN)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trained:
    """Training patches, and the segments whose label is wrong."""

    patches: list[LabelledPatch]
    wrong: set[str]


def features_of(thing: Thing, scene: Scene, rng: np.random.Generator) -> PatchFeatures:
    """Return the features of a thing that is seen."""
    features = extract_features(draw_patch(thing, scene, rng), mm_per_px=scene.mm_per_px)
    assert isinstance(features, PatchFeatures)
    return features


def training_set(scene: Scene, *, seed: int, segments: int, patches: int) -> Trained:
    """Return segments of which every fourth is labelled as another thing."""
    rng = np.random.default_rng(seed)
    made, wrong = [], set()
    for segment in range(segments):
        true = (COLOURS[rng.integers(3)], SHAPES[rng.integers(3)])
        said = true
        while segment % 4 == 3 and said == true:
            said = (COLOURS[rng.integers(3)], SHAPES[rng.integers(3)])
        if said != true:
            wrong.add(str(segment))
        made += [
            LabelledPatch(
                features=features_of(Thing(colour=true[0], shape=Shape(true[1])), scene, rng),
                symbols=said,
                segment=str(segment),
                name=f"{segment}-{number}",
            )
            for number in range(patches)
        ]
    return Trained(patches=made, wrong=wrong)


def things_to_name(
    scene: Scene, *, seed: int, rounds: int
) -> Iterator[tuple[str, str, PatchFeatures]]:
    """Yield (concept, expected word or "unknown", features)."""
    rng = np.random.default_rng(seed)
    for _ in range(rounds):
        for colour in COLOURS:
            yield "colour", colour, features_of(Thing(colour=colour, shape=Shape.DISC), scene, rng)
        for colour in NEW_COLOURS:
            thing = Thing(colour=colour, shape=Shape(SHAPES[rng.integers(3)]))
            yield "colour", "unknown", features_of(thing, scene, rng)
        for shape in SHAPES:
            thing = Thing(colour=NEW_COLOURS[rng.integers(4)], shape=Shape(shape))
            yield "shape", shape, features_of(thing, scene, rng)
        for shape in NEW_SHAPES:
            thing = Thing(colour=COLOURS[rng.integers(3)], shape=shape)
            yield "shape", "unknown", features_of(thing, scene, rng)


def share_right(
    model: SymbolModel, things: list[tuple[str, str, PatchFeatures]]
) -> dict[tuple[str, bool], float]:
    """Return the share named right for each (concept, is known)."""
    classifier = Classifier(model)
    right: dict[tuple[str, bool], list[bool]] = {}
    for concept, expected, features in things:
        said = {each.symbol for each in classifier.classify(features) if each.known}
        said &= set(COLOURS if concept == "colour" else SHAPES)
        key = (concept, expected != "unknown")
        right.setdefault(key, []).append(said == ({expected} if key[1] else set()))
    return {key: float(np.mean(values)) for key, values in right.items()}


def relabelled(patch: LabelledPatch, old: str, new: str) -> LabelledPatch:
    """Return a patch of which another word was said."""
    return replace(patch, symbols=tuple(new if word == old else word for word in patch.symbols))
