"""The colours of a thing and of what surrounds it, as histograms."""

from dataclasses import dataclass

import cv2
import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray, IntArray
from gazemap.scene.colour_counts import count_colours, spread_ratio
from gazemap.scene.crops import Crop
from gazemap.scene.silhouette import mask_inside, masks_inside

_BINS = 16
_LOG_ODDS_LIMIT = 3.0
# Share of the probability that is spread over all colours, for those never seen.
_UNSEEN = 1e-2
# Things cast shadows beside them: what is around has darker versions of its colours as well.
_SHADES = (0.35, 0.45, 0.55, 0.65, 0.75, 0.85)
_SHADE_STRIDE = 3
_SHADE_SHARE = 0.3
_MIN_VISIBLE = 0.25
# Neighbouring bins share what falls near their border: a Gaussian of 0.7 bins.
_BLUR = np.exp(-0.5 * (np.subtract.outer(np.arange(_BINS), np.arange(_BINS)) / 0.7) ** 2)
_BLUR /= _BLUR.sum(axis=1, keepdims=True)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ColourModel:
    """How often a thing shows each colour, for each kind of camera.

    Attributes:
        log_density: {is_overhead: (bins,)}.
    """

    log_density: dict[bool, FloatArray]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Neighbour:
    """Another thing that stands in sight.

    Attributes:
        shape: (7,) its box, as `silhouette` takes it.
        is_alike: whether its colours are about those of what the cut-outs look at.
    """

    shape: FloatArray
    is_alike: bool


class ColourDivision:
    """Cut-outs of one thing, each pixel sorted into a bin of colours."""

    def __init__(self, crops: list[Crop], *, neighbours: tuple[Neighbour, ...] = ()) -> None:
        """Sort the pixels of at least one cut-out; all are of one size.

        Args:
            crops: the cut-outs.
            neighbours: other things; where one stands in front of what a cut-out looks at, its
                pixels say nothing, and neither do those of one that looks the same.
        """
        self.crops = crops
        self.size_px = crops[0].image.shape[0]
        self.projections = np.stack([c.projection for c in crops])
        self._bins = np.stack([_colour_bins(c.image) for c in crops])
        self._shaded = np.stack([_shaded_bins(c.image) for c in crops])
        self._valid = np.stack([c.valid & ~_hidden(c, neighbours) for c in crops])
        kinds = np.array([c.is_overhead for c in crops])
        self._views = {bool(k): np.flatnonzero(kinds == k) for k in np.unique(kinds)}

    def masks(self, shape: FloatArray) -> BoolArray:
        """Return the silhouettes of a box in all cut-outs (V, n, n)."""
        return masks_inside(shape, self.projections, self.size_px)

    def log_odds(
        self, shape: FloatArray, inside_model: ColourModel | None = None
    ) -> tuple[FloatArray, float]:
        """Return log-odds of inside to outside (V, n, n), and the division's log-likelihood.

        The colours are learnt for each camera on its own, for two cameras see them differently;
        those inside are taken as given where the thing is known.
        """
        masks = self.masks(shape)
        odds = np.zeros(masks.shape)
        total = 0.0
        for kind, views in self._views.items():
            inside, outside, shadow = count_colours(
                self._bins, self._shaded, self._valid, masks, views, _BINS**3
            )
            known = inside_model.log_density.get(kind) if inside_model else None
            log_in = _log_density(inside) if known is None else known
            log_out = _log_density(outside, shadow)
            ratio = np.clip(log_in - log_out, -_LOG_ODDS_LIMIT, _LOG_ODDS_LIMIT)
            spread_ratio(ratio, self._bins, self._valid, views, odds)
            total += float(log_in @ inside + log_out @ outside)
        return odds, total

    def clarity(self, shape: FloatArray, inside_model: ColourModel | None = None) -> float:
        """Return the mean log-odds inside the silhouette, in the view where it is least.

        Views from which it is mostly hidden do not count: slivers are of no clear colour.
        """
        odds, _ = self.log_odds(shape, inside_model)
        whole = self.masks(shape)
        inside = whole & self._valid
        means = [
            float(o[m].mean())
            for o, m, w in zip(odds, inside, whole, strict=True)
            if m.any() and m.sum() >= _MIN_VISIBLE * w.sum()
        ]
        return min(means, default=0.0)

    def model(self, shape: FloatArray) -> ColourModel:
        """Return the colours inside a box's silhouettes."""
        masks = self.masks(shape) & self._valid
        return ColourModel(
            log_density={
                kind: _log_density(_counts(self._bins[views][masks[views]]))
                for kind, views in self._views.items()
            }
        )


def _hidden(crop: Crop, neighbours: tuple[Neighbour, ...]) -> BoolArray:
    """Return the pixels (n, n) of a cut-out that say nothing, for a neighbour is seen there."""
    size_px = crop.image.shape[0]
    hidden = np.zeros((size_px, size_px), dtype=np.uint8)
    for each in neighbours:
        is_nearer = crop.projection[2] @ np.append(each.shape[:3], 1.0) < crop.distance_m
        if is_nearer or each.is_alike:
            hidden |= mask_inside(each.shape, crop.projection, size_px).astype(np.uint8)
    return np.asarray(cv2.dilate(hidden, np.ones((3, 3), np.uint8)).astype(bool))


def _shaded_bins(image: ImageArray) -> IntArray:
    """Return the bins (n', n', S) that every few pixels would have in shadows."""
    few = image[::_SHADE_STRIDE, ::_SHADE_STRIDE]
    return np.stack([_colour_bins((few * s).astype(np.uint8)) for s in _SHADES], axis=-1)


def _colour_bins(image: ImageArray) -> IntArray:
    lab = cv2.cvtColor(image, cv2.COLOR_BGR2LAB).astype(np.int64)
    level = lab[..., 0] * _BINS // 256
    # The two chroma axes use a part of their range only: twice as fine, and cut at the ends.
    a, b = (np.clip((lab[..., k] - 64) * _BINS // 128, 0, _BINS - 1) for k in (1, 2))
    return np.asarray((level * _BINS + a) * _BINS + b)


def _counts(bins: IntArray) -> FloatArray:
    return np.bincount(bins, minlength=_BINS**3).astype(np.float64)


def _log_density(counts: FloatArray, shadow: FloatArray | None = None) -> FloatArray:
    """Return log-densities (bins,) of colours, and of their shaded versions as rarer ones."""
    pixels = counts.sum()
    if shadow is not None and shadow.any():
        counts = counts + _SHADE_SHARE * pixels / shadow.sum() * shadow
    counts = counts.reshape((_BINS,) * 3)
    for axis in range(3):
        counts = np.moveaxis(np.tensordot(_BLUR, counts, axes=(1, axis)), 0, axis)
    smooth = counts + _UNSEEN * max(pixels, 1.0) / _BINS**3
    density: FloatArray = np.log(smooth / smooth.sum()).ravel()
    return density
