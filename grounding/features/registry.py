"""The registry of features: a name, a unit, and a function of patch, mask and metric scale.

A new feature is one entry of `FEATURES`. `resolution` is the smallest difference that means
anything: two patches of one thing, seen under a slightly different light or from a slightly
different side, differ by about so much. Learning measures in these units, so no spread is ever
believed to be smaller.
"""

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

import cv2
import numpy as np

from grounding.errors import ConfigError
from grounding.features import colour, shape, size
from grounding.features.background import Mask, NoObject, segment_object
from grounding.features.embedding import EMBEDDING_SIZE, Embedding
from grounding.features.patch import ZERNIKE_ORDERS, MaskedPatch
from grounding.types import FloatArray, ImageArray

_WORKING_SIDE_PX: Final = 160


class Family(StrEnum):
    """What a feature measures."""

    COLOUR = "colour"
    SIZE = "size"
    SHAPE = "shape"
    EMBEDDING = "embedding"


@dataclass(frozen=True, slots=True, kw_only=True)
class Feature:
    """One entry of the registry.

    Attributes:
        name: how models and pictures call it.
        unit: what it is counted in.
        family: what it measures.
        measure: the function.
        resolution: the smallest difference that means anything, in `unit`.
        raw: kept for the paper's experiment; `robust` takes it only when nothing else of its
            family could be measured.
        light_gain: the feature rises by `light_gain * (value + light_base)` when the light grows
            by one natural logarithm.
        light_base: see `light_gain`.
    """

    name: str
    unit: str
    family: Family
    measure: Callable[[MaskedPatch], float]
    resolution: float
    raw: bool = False
    light_gain: float = 0.0
    light_base: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PatchFeatures:
    """The features of one patch; NaN where a feature could not be measured.

    Attributes:
        names: of the features.
        values: (D,) each in its own unit.
    """

    names: tuple[str, ...]
    values: FloatArray

    def __getitem__(self, name: str) -> float:
        """Return one feature."""
        return float(self.values[self.names.index(name)])


def _colour_features() -> list[Feature]:
    gains = {"grey level": 1 / 2.2, "L*": 1 / 3, "a*": 1 / 3, "b*": 1 / 3}  # gamma; CIELAB's root

    def entry(
        name: str, unit: str, measure: Callable[[MaskedPatch], float], resolution: float
    ) -> Feature:
        return Feature(
            name=name,
            unit=unit,
            family=Family.COLOUR,
            measure=measure,
            resolution=resolution,
            raw=unit == "grey level",
            light_gain=gains.get(unit, 0.0),
            light_base=16.0 if unit == "L*" else 0.0,
        )

    channel, lab = colour.mean_channel, colour.lab
    return [
        entry("red", "grey level", functools.partial(channel, channel=2), 15.0),
        entry("green", "grey level", functools.partial(channel, channel=1), 15.0),
        entry("blue", "grey level", functools.partial(channel, channel=0), 15.0),
        entry("lightness", "L*", functools.partial(lab, channel=0), 12.0),
        entry("lab a", "a*", functools.partial(lab, channel=1), 10.0),
        entry("lab b", "b*", functools.partial(lab, channel=2), 10.0),
        entry("saturation east", "1", colour.saturation_east, 0.07),
        entry("saturation north", "1", colour.saturation_north, 0.07),
    ]


def _size_features() -> list[Feature]:
    def entry(
        name: str, unit: str, measure: Callable[[MaskedPatch], float], resolution: float
    ) -> Feature:
        return Feature(
            name=name,
            unit=unit,
            family=Family.SIZE,
            measure=measure,
            resolution=resolution,
            raw="px" in unit,
        )

    return [
        entry("pixel area", "px", size.pixel_area, 50.0),
        entry("log pixel area", "ln px", size.log_pixel_area, 0.04),
        entry("log area", "ln mm", size.log_area, 0.04),
        entry("log length", "ln mm", size.log_length, 0.04),
        entry("log width", "ln mm", size.log_width, 0.04),
        entry("log height", "ln mm", size.log_height, 0.08),
    ]


def _shape_features() -> list[Feature]:
    def entry(name: str, measure: Callable[[MaskedPatch], float], resolution: float) -> Feature:
        return Feature(
            name=name, unit="1", family=Family.SHAPE, measure=measure, resolution=resolution
        )

    hu, zernike, fourier = shape.hu, shape.zernike, shape.fourier
    return [
        entry("solidity", shape.solidity, 0.02),
        entry("circularity", shape.circularity, 0.02),
        entry("rectangularity", shape.rectangularity, 0.025),
        entry("elongation", shape.elongation, 0.06),
        entry("hole", shape.hole, 0.02),
        *(entry(f"hu {k + 1}", functools.partial(hu, order=k), 0.01) for k in range(3)),
        *(
            entry(f"zernike {n},{m}", functools.partial(zernike, order=(n, m)), 0.03)
            for n, m in ZERNIKE_ORDERS
        ),
        *(
            entry(f"fourier {k}", functools.partial(fourier, order=k), 0.02)
            for k in shape.FOURIER_ORDERS
        ),
    ]


def _embedding_features() -> list[Feature]:
    def entry(number: int) -> Feature:
        return Feature(
            name=f"embedding {number + 1}",
            unit="1",
            family=Family.EMBEDDING,
            measure=lambda patch: np.nan if patch.embedding is None else patch.embedding[number],
            resolution=0.05,
        )

    return [entry(number) for number in range(EMBEDDING_SIZE)]


FEATURES: Final[dict[str, Feature]] = {
    feature.name: feature
    for feature in [
        *_colour_features(),
        *_size_features(),
        *_shape_features(),
        *_embedding_features(),
    ]
}
PAPER_FEATURES: Final = ("red", "green", "blue", "pixel area")


def features_named(names: Sequence[str]) -> tuple[Feature, ...]:
    """Return entries of the registry.

    Raises:
        ConfigError: if a name is not in the registry.
    """
    unknown = [name for name in names if name not in FEATURES]
    if unknown:
        raise ConfigError(f"no feature is called {unknown[0]!r}; there are: {', '.join(FEATURES)}")
    return tuple(FEATURES[name] for name in names)


def extract_features(
    image_bgr: ImageArray,
    *,
    mask: Mask | None = None,
    mm_per_px: float | None = None,
    height_mm: float | None = None,
    white_bgr: tuple[float, float, float] | None = None,
    embedding: Embedding | None = None,
) -> PatchFeatures | NoObject:
    """Measure every feature of the object in the middle of a patch.

    Args:
        image_bgr: (H, W, 3) the patch.
        mask: (H, W) the object, where it is known; else it is found against the table.
        mm_per_px: metric scale in the object's plane; without it sizes in mm are NaN.
        height_mm: the object's height where the scene gives it.
        white_bgr: how a white surface looks under this light; None trusts the camera's balance.
        embedding: a network of the user's; without it its features are NaN.

    Returns:
        The features, or NoObject with the reason.
    """
    shrink = min(1.0, _WORKING_SIDE_PX / max(image_bgr.shape[:2]))
    if shrink < 1:
        size_px = [max(1, round(side * shrink)) for side in image_bgr.shape[1::-1]]
        image_bgr = np.asarray(cv2.resize(image_bgr, size_px, interpolation=cv2.INTER_AREA))
        if mask is not None:
            mask = cv2.resize(mask.astype(np.uint8), size_px, interpolation=cv2.INTER_AREA) > 0
    found = segment_object(image_bgr) if mask is None else mask
    if isinstance(found, NoObject):
        return found
    patch = MaskedPatch(
        image_bgr=image_bgr,
        mask=found,
        mm_per_px=mm_per_px / shrink if mm_per_px else None,
        height_mm=height_mm,
        white_bgr=white_bgr,
        embedding=None if embedding is None else embedding(image_bgr, found),
    )
    return PatchFeatures(
        names=tuple(FEATURES),
        values=np.array([feature.measure(patch) for feature in FEATURES.values()]),
    )
