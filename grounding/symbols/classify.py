"""Say which words a patch bears, one for each concept group, or that it is unknown."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from grounding.features.registry import PatchFeatures
from grounding.symbols.calibration import Calibration
from grounding.symbols.density import GroupDensity, LightSlope, density, predictive
from grounding.symbols.model import Group, SymbolModel
from grounding.symbols.records import Classification, Mode
from grounding.types import FloatArray

_SEEN: Final = 1e-6  # of a patch: what was never believed has no meaning
_TOLD: Final = 3.0  # log odds, where a feature is missing
_LEAST_VARIANCE: Final = 1e-6  # of the scaled range


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class KnownGroup:
    """A group made ready: its words that were seen, their features' places, their densities."""

    group: Group
    words: tuple[str, ...]
    columns: list[int]
    density: GroupDensity


class Classifier:
    """A model made ready to classify many patches: the densities are worked out once."""

    def __init__(self, model: SymbolModel) -> None:
        """Work out the densities of every group."""
        self._model = model
        known = (know_group(model, group) for group in model.groups)
        self._groups = [each for each in known if each is not None]
        self._calibrations = {
            each.group.name: Calibration.of(
                each.group.distances, dimension=len(each.group.features)
            )
            for each in self._groups
            if len(each.group.distances)
        }

    def classify(self, features: PatchFeatures) -> list[Classification]:
        """Return each group's word for a patch, compounds only where their head is known."""
        sample = self._model.scale(features)
        found = [self._in_group(known, sample[known.columns]) for known in self._groups]
        said = {each.symbol for each in found if each.known}
        kinds = {known.group.name: known.group.kind_of for known in self._groups}
        return [
            replace(each, known=each.known and kinds[each.group] in {"", *said}) for each in found
        ]

    def _in_group(self, known: KnownGroup, sample: FloatArray) -> Classification:
        logs = known.density.log_densities(sample[None])[0]
        best = int(np.argmax(logs))
        squared = float(known.density.squared_distances(sample[None])[0, best])
        if self._model.config.mode is Mode.PAPER:
            limit = self._model.config.paper.density_sigmas
            score, believed = float(np.exp(logs[best])), squared <= limit**2 * len(sample)
        else:
            calibration = self._calibrations.get(known.group.name)
            score = calibration.p_value(math.sqrt(squared)) if calibration else 0.0
            believed = score >= self._model.config.robust.unknown_rate and _is_told(logs, sample)
        return Classification(
            group=known.group.name,
            symbol=known.words[best],
            score=score,
            known=believed and known.group.is_sure,
        )


def _is_told(logs: FloatArray, sample: FloatArray) -> bool:
    """Return whether the features that a patch has tell the best word from the others.

    Without a metric scale a small cube and a large one look alike: then neither is known.
    """
    if np.isfinite(sample).all() or len(logs) < 2:
        return True
    runner_up, best = np.sort(logs)[-2:]
    return bool(best - runner_up > _TOLD)


def classify(model: SymbolModel, features: PatchFeatures) -> list[Classification]:
    """Return each concept group's word for one patch; for many, keep a `Classifier`."""
    return Classifier(model).classify(features)


def know_group(model: SymbolModel, group: Group) -> KnownGroup | None:
    """Return a group with the densities of its words, or None if nothing is known of it."""
    words = tuple(word for word in group.words if model.words[word].moments.weight > _SEEN)
    if not words or not group.features:
        return None
    columns = model.columns(group.features)
    moments = [model.words[word].moments for word in words]
    if model.config.mode is Mode.ROBUST:
        light = LightSlope.of(model.features, model.offset, model.unit)
        weight = model.config.robust.covariance_weight
        words_density = predictive(moments, columns, weight, light)
    else:
        variances = [np.diag(each.scatter)[columns] / each.weight for each in moments]
        words_density = density(
            [each.mean[columns] for each in moments],
            [np.diag(np.maximum(variance, _LEAST_VARIANCE)) for variance in variances],
            np.full(len(moments), np.inf),
        )
    return KnownGroup(group=group, words=words, columns=columns, density=words_density)


def unexplained_groups(model: SymbolModel, found: Sequence[Classification]) -> tuple[str, ...]:
    """Return the groups none of whose words explains a patch.

    A sure group whose best word would explain it, but that is not told from the others because a
    feature is missing (a size, without a metric scale), is not among them.
    """
    rate = model.config.robust.unknown_rate if model.config.mode is Mode.ROBUST else np.inf
    return tuple(
        each.group
        for each in found
        if not each.known and not (each.score >= rate and model.group_named(each.group).is_sure)
    )
