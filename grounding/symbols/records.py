"""The records that go into learning and come out of it."""

from dataclasses import dataclass, field
from enum import StrEnum

from grounding.errors import ConfigError
from grounding.features.background import NoObject
from grounding.features.registry import PatchFeatures


class Mode(StrEnum):
    """How meanings are learnt."""

    ROBUST = "robust"
    PAPER = "paper"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LabelledPatch:
    """A patch with the words that were said of it.

    Attributes:
        features: what was measured, or that there was nothing to measure.
        symbols: the words, in the order spoken.
        segment: names the labelling decision; patches of one segment are right or wrong together.
        weight: the posterior that the label is right, in (0, 1].
        name: how the patch is called in reports.
    """

    features: PatchFeatures | NoObject
    symbols: tuple[str, ...]
    segment: str
    weight: float = 1.0
    name: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Classification:
    """What one concept group says of a patch.

    Attributes:
        group: the concept group.
        symbol: its best symbol, even where it is not known.
        score: robust: the share of the symbol's own patches that are less typical than this one
            (a calibrated p-value); paper: the density.
        known: whether the symbol is believed.
    """

    group: str
    symbol: str
    score: float
    known: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class PatchDecision:
    """Whether a patch was kept for a word, and if not, why."""

    patch: str
    segment: str
    symbol: str
    kept: bool
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperConfig:
    """Thresholds of Algorithm 1; the paper names them and gives no numbers.

    Attributes:
        sigma_thresh: a feature, scaled to [0, 1], is invariant below this standard deviation.
        cleaning_sigmas: samples beyond so many standard deviations are dropped.
        density_sigmas: a density is believed up to that of a point so many standard deviations
            off in each invariant feature.
    """

    sigma_thresh: float = 0.15
    cleaning_sigmas: float = 2.0
    density_sigmas: float = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class RobustConfig:
    """The noise model of `robust`.

    Attributes:
        unknown_rate: the share of known things that may be called unknown.
        wrong_rate: the share of segments that is expected to be labelled wrong.
        wrong_rate_weight: how many segments that expectation is worth.
        covariance_weight: how many patches the group's common spread is worth to one word's.
        tail_dof: degrees of freedom of a patch's likelihood; low bears more stray patches.
        segment_correlation: correlation between patches of one segment.
        seed: of the permutation tests.
    """

    unknown_rate: float = 0.001
    wrong_rate: float = 0.25
    wrong_rate_weight: float = 8.0
    covariance_weight: float = 20.0
    tail_dof: float = 5.0
    segment_correlation: float = 0.3
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse rates that are none.

        Raises:
            ConfigError: if a rate is out of its range.
        """
        if not 0 < self.unknown_rate < 0.5:
            raise ConfigError(f"unknown_rate is {self.unknown_rate}, expected within (0, 0.5)")
        if not 0 < self.wrong_rate < 0.5:
            raise ConfigError(f"wrong_rate is {self.wrong_rate}, expected within (0, 0.5)")


@dataclass(frozen=True, slots=True, kw_only=True)
class SymbolConfig:
    """How symbols are learnt.

    Attributes:
        mode: `robust` or the paper's algorithm.
        features: names of the features to learn from; empty takes the mode's own.
        robust: the noise model of `robust`.
        paper: the thresholds of `paper`.
    """

    mode: Mode = Mode.ROBUST
    features: tuple[str, ...] = ()
    robust: RobustConfig = field(default_factory=RobustConfig)
    paper: PaperConfig = field(default_factory=PaperConfig)
