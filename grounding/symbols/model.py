"""What has been learnt: words, their moments, and the concept groups.

A word is kept as the moments of the patches that were believed, over all features at once. From
moments follow means, spreads, groups' common spreads and predictions, so a model is as large
after a million patches as after ten, and a new patch is one addition.
"""

from dataclasses import dataclass, field
from functools import cached_property

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

    def plus(self, other: "Moments", *, sign: float = 1.0) -> "Moments":
        """Return the moments of both together; with sign -1, of this without the other.

        Source:
            Chan, Golub and LeVeque 1979, eq. 2.1.
        """
        weight = self.weight + sign * other.weight
        if weight <= 1e-9:
            return Moments.none(len(self.mean))
        offset = other.mean - self.mean
        share = sign * other.weight / weight
        scatter = self.scatter + sign * other.scatter
        return Moments(
            weight=weight,
            effective=max(0.0, self.effective + sign * other.effective),
            mean=self.mean + share * offset,
            scatter=scatter + (self.weight * share) * np.outer(offset, offset),
        )

    def scaled(self, factor: float) -> "Moments":
        """Return the moments with every weight multiplied."""
        return Moments(
            weight=self.weight * factor,
            effective=self.effective * factor,
            mean=self.mean,
            scatter=self.scatter * factor,
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Word:
    """One symbol.

    Attributes:
        moments: of the patches that were believed.
        kept: how many patches were believed.
        dropped: how many were not.
    """

    moments: Moments
    kept: int
    dropped: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Group:
    """Words that describe the same features and exclude each other.

    Attributes:
        name: what it describes, or the word itself where it stands alone.
        words: in alphabetical order.
        features: what it describes; all features while too little is known to say.
        is_sure: whether it is known what the words describe.
        distances: sorted distances of known patches from their words, each measured with a model
            that had not seen its segment; at most some hundred.
    """

    name: str
    words: tuple[str, ...]
    features: tuple[str, ...]
    distances: FloatArray
    is_sure: bool


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
        aliases: other words for a word that is kept.
        decisions: which patches of the fit were kept, and why others were not.
    """

    config: SymbolConfig
    features: tuple[str, ...]
    offset: FloatArray
    unit: FloatArray
    words: dict[str, Word]
    groups: tuple[Group, ...]
    anything: Moments
    aliases: dict[str, str] = field(default_factory=dict)
    decisions: tuple[PatchDecision, ...] = ()

    @cached_property
    def families(self) -> tuple[Family, ...]:
        """(D,) of each feature."""
        return tuple(FEATURES[name].family for name in self.features)

    def group_of(self, word: str) -> Group | None:
        """Return the group that holds a word or what it is an alias of."""
        name = self.aliases.get(word, word)
        return next((group for group in self.groups if name in group.words), None)

    def columns(self, names: tuple[str, ...]) -> list[int]:
        """Return the places of features in the moments."""
        return [self.features.index(name) for name in names]

    def scale(self, features: PatchFeatures) -> FloatArray:
        """Return a patch's features (D,) as moments hold them; NaN where one is missing."""
        values = np.array([features[name] for name in self.features])
        scaled: FloatArray = (values - self.offset) / self.unit
        return scaled
