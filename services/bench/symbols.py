"""Learning on and classifying words: time for a patch, and memory over many patches."""

import tracemalloc
from collections.abc import Callable, Sequence
from itertools import cycle

import cv2
import mahotas
import numpy as np

from grounding.features.registry import PatchFeatures, extract_features
from grounding.symbols.classify import Classifier
from grounding.symbols.learn import fit_symbols
from grounding.symbols.model import SymbolModel
from grounding.symbols.online import update
from grounding.symbols.records import LabelledPatch, SymbolConfig
from grounding.symbols.reproduce import training_patches
from grounding.symbols.simulated import Scene, Shape, Thing, draw_patch
from grounding.types import ImageArray
from services.bench.figures import Figure, median_ms

_PATCHES = 150
_IMAGES = 30


def run() -> list[Figure]:
    """Measure; the peer is mahotas, which computes the Zernike moments of one mask alone."""
    cv2.setNumThreads(1)
    rng = np.random.default_rng(0)
    patches = list(training_patches(rng, count=_PATCHES))
    model = fit_symbols(patches, SymbolConfig())
    images = [
        draw_patch(Thing(colour="red", shape=Shape.CUBE), Scene(), rng) for _ in range(_IMAGES)
    ]
    peer_ms = _peer_ms(images)
    update_ms = _per_image(images, lambda image: _learn(model, image))
    classifier = Classifier(model)
    classify_ms = _per_image(images, lambda image: _name(classifier, image))
    few, many = _memory_kib(model, patches, 2000), _memory_kib(model, patches, 4000)
    peer = "mahotas, Zernike moments alone"
    return [
        Figure(
            name="update with features", value=update_ms, unit="ms", peer=peer, peer_value=peer_ms
        ),
        Figure(
            name="classify with features",
            value=classify_ms,
            unit="ms",
            peer=peer,
            peer_value=peer_ms,
        ),
        Figure(name="classified on one core", value=1000 / classify_ms, unit="1/s"),
        Figure(
            name="memory after 4000 updates",
            value=many,
            unit="KiB",
            peer="after 2000",
            peer_value=few,
        ),
    ]


def _per_image(images: Sequence[ImageArray], work: Callable[[ImageArray], object]) -> float:
    turn = cycle(images)
    return median_ms(lambda: work(next(turn)), repeats=4 * len(images))


def _learn(model: SymbolModel, image: ImageArray) -> SymbolModel:
    features = extract_features(image, mm_per_px=1.0)
    return update(model, LabelledPatch(features=features, symbols=("red", "cube"), segment="a"))


def _name(classifier: Classifier, image: ImageArray) -> object:
    features = extract_features(image, mm_per_px=1.0)
    return classifier.classify(features) if isinstance(features, PatchFeatures) else None


def _peer_ms(images: Sequence[ImageArray]) -> float:
    """Return the time that another library takes for one family of features alone."""
    masks = [image[..., 2] > image[..., 0].mean() + 60 for image in images]
    turn = cycle(masks)
    return median_ms(
        lambda: mahotas.features.zernike_moments(next(turn), 60, degree=6), repeats=len(masks)
    )


def _memory_kib(model: SymbolModel, patches: Sequence[LabelledPatch], count: int) -> float:
    """Return what a model takes after so many updates, each word in a new segment by and by."""
    tracemalloc.start()
    turn = cycle(patches)
    for number in range(count):
        patch = next(turn)
        segment = f"{patch.segment} {number // len(patches)}"
        model = update(
            model,
            LabelledPatch(features=patch.features, symbols=patch.symbols, segment=segment),
        )
    held, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return held / 1024
