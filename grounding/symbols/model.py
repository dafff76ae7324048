"""What has been learnt: words, their moments, and the concept groups.

A word is kept as the moments of the patches that were believed, over all features at once. From
moments follow means, spreads, groups' common spreads and predictions, so a model is as large
after a million patches as after ten, and a new patch is one addition.
"""

from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import Final

import numpy as np

from grounding.features.registry import FEATURES, Family, PatchFeatures
from grounding.symbols.records import PatchDecision, SymbolConfig
from grounding.types import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Moments:
    """Weighted moments of patches, in a model's scaled features.

    Attributes:
        weight: the sum of the patches' weights.
        effective: the same with the patches of one segment counted as the correlated ones they are.
        mean: (D,).
        scatter: (D, D) sum of weighted outer products about the mean.
    """

    weight: float
    effective: float
    mean: FloatArray
    scatter: FloatArray

    @staticmethod
    def none(dimension: int) -> "Moments":
        """Return the moments of no patches."""
        return Moments(
            weight=0.0,
            effective=0.0,
            mean=np.zeros(dimension),
            scatter=np.zeros((dimension, dimension)),
        )

    @staticmethod
    def single(sample: FloatArray, weight: float) -> "Moments":
        """Return the moments of one sample (D,)."""
        return Moments(
            weight=weight,
            effective=weight,
            mean=sample,
            scatter=np.zeros((len(sample), len(sample))),
        )

    @staticmethod
    def of(samples: FloatArray, weights: FloatArray, *, effective: float) -> "Moments":
        """Return the moments of samples (N, D) with weights (N,)."""
        total = float(weights.sum())
        if total <= 0:
            return Moments.none(samples.shape[1])
        mean = weights @ samples / total
        offsets = samples - mean
        return Moments(
            weight=total,
            effective=effective,
            mean=mean,
            scatter=(offsets * weights[:, None]).T @ offsets,
        )

    def plus(self, other: "Moments") -> "Moments":
        """Return the moments of both together; a negative weight takes patches back.

        Source:
            Chan, Golub and LeVeque 1979, eq. 2.1.
        """
        weight = self.weight + other.weight
        if weight <= 1e-9:
            return Moments.none(len(self.mean))
        offset = other.mean - self.mean
        share = other.weight / weight
        spread = (self.weight * share) * np.outer(offset, offset)
        return Moments(
            weight=weight,
            effective=max(0.0, self.effective + other.effective),
            mean=self.mean + share * offset,
            scatter=self.scatter + other.scatter + spread,
        )

    def scaled(self, factor: float) -> "Moments":
        """Return the moments with every weight multiplied."""
        return Moments(
            weight=self.weight * factor,
            effective=self.effective * factor,
            mean=self.mean,
            scatter=self.scatter * factor,
        )


MAX_EXAMPLES: Final = 40


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Word:
    """One symbol.

    Attributes:
        moments: of the patches that were believed.
        kept: how many patches were believed.
        dropped: how many were not.
        examples: (M, D) of those that were believed, for pictures; at most some tens.
        strays: (M, D) of those that were not.
    """

    moments: Moments
    kept: int
    dropped: int
    examples: FloatArray = field(default_factory=lambda: np.empty((0, 0)))
    strays: FloatArray = field(default_factory=lambda: np.empty((0, 0)))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Group:
    """Words that describe the same features and exclude each other.

    A group with `kind_of` holds the compounds of that head (steak knife, bread knife): it speaks
    only of things that the head's own group knows as the head.

    Attributes:
        name: what it describes, or the word itself where it stands alone.
        words: in alphabetical order.
        features: what it describes; all features while too little is known to say.
        is_sure: whether it is known what the words describe.
        kind_of: the head of the compounds that it holds; empty for a group of plain words.
        distances: sorted distances of known patches from their words, each measured with a model
            that had not seen its segment; at most some hundred.
    """

    name: str
    words: tuple[str, ...]
    features: tuple[str, ...]
    distances: FloatArray
    is_sure: bool
    kind_of: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OpenSegment:
    """A segment that may get further patches: its label is weighed anew with each.

    Attributes:
        segment: its name.
        word: the word it bears, of one group.
        patches: how many it has.
        log_odds: of its label being right, summed over its patches, without the prior.
        right: probability that the label is right, as it was last added to the word.
        moments: of its patches as if the label were right.
    """

    segment: str
    word: str
    patches: int
    log_odds: float
    right: float
    moments: Moments


@dataclass(frozen=True, kw_only=True, eq=False)
class SymbolModel:
    """All that is known of words; made by `fit_symbols`, never changed in place.

    Attributes:
        config: how it was learnt.
        features: (D names) that moments are over.
        offset: (D,) taken from a feature, then divided by `unit`, before anything is learnt.
        unit: (D,).
        words: by name.
        groups: concept groups.
        anything: moments of all patches, whatever was said of them.
        lexicons: person -> their own word -> the word that is kept; person "" is everyone.
        open_segments: the latest segments that were learnt on, at most some ten.
        decisions: which patches of the fit were kept, and why others were not.
    """

    config: SymbolConfig
    features: tuple[str, ...]
    offset: FloatArray
    unit: FloatArray
    words: dict[str, Word]
    groups: tuple[Group, ...]
    anything: Moments
    lexicons: dict[str, dict[str, str]] = field(default_factory=dict)
    open_segments: tuple[OpenSegment, ...] = ()
    decisions: tuple[PatchDecision, ...] = ()

    @cached_property
    def families(self) -> tuple[Family, ...]:
        """(D,) of each feature."""
        return tuple(FEATURES[name].family for name in self.features)

    def group_of(self, word: str) -> Group | None:
        """Return the group that holds a word."""
        return next((group for group in self.groups if word in group.words), None)

    def group_named(self, name: str) -> Group:
        """Return the group of a name."""
        return next(group for group in self.groups if group.name == name)

    def columns(self, names: tuple[str, ...]) -> list[int]:
        """Return the places of features in the moments."""
        return list(_places(names, self.features))

    def scale(self, features: PatchFeatures) -> FloatArray:
        """Return a patch's features (D,) as moments hold them; NaN where one is missing."""
        places = np.array(_places(self.features, features.names), np.intp)
        values = np.where(places >= 0, features.values[places], np.nan)
        scaled: FloatArray = (values - self.offset) / self.unit
        return scaled


@cache
def _places(names: tuple[str, ...], among: tuple[str, ...]) -> tuple[int, ...]:
    """Return where each name stands among others; -1 for one that is not there."""
    order = {name: place for place, name in enumerate(among)}
    return tuple(order.get(name, -1) for name in names)
