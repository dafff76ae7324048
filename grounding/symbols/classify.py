"""Say which words a patch bears, one for each concept group, or that it is unknown."""

from collections.abc import Sequence

import numpy as np

from grounding.features.registry import PatchFeatures
from grounding.symbols.calibration import p_values
from grounding.symbols.density import GroupDensity, density, predictive
from grounding.symbols.model import Group, SymbolModel
from grounding.symbols.records import Classification, Mode
from grounding.types import FloatArray


class Classifier:
    """A model made ready to classify many patches: the densities are worked out once."""

    def __init__(self, model: SymbolModel) -> None:
        """Work out the densities of every group."""
        self._model = model
        self._groups = [
            (group, model.columns(group.features), group_density(model, group))
            for group in model.groups
            if group.features
        ]

    def classify(self, features: PatchFeatures) -> list[Classification]:
        """Return each group's word for a patch."""
        sample = self._model.scale(features)
        return [
            self._in_group(group, words, sample[columns]) for group, columns, words in self._groups
        ]

    def _in_group(self, group: Group, words: GroupDensity, sample: FloatArray) -> Classification:
        logs = words.log_densities(sample[None])[0]
        best = int(np.argmax(logs))
        squared = float(words.squared_distances(sample[None])[0, best])
        if self._model.config.mode is Mode.PAPER:
            limit = self._model.config.paper.density_sigmas
            score, known = float(np.exp(logs[best])), squared <= limit**2 * len(sample)
        else:
            score = typicality(group, squared)
            known = score >= self._model.config.robust.unknown_rate
        return Classification(
            group=group.name, symbol=group.words[best], score=score, known=known and group.is_sure
        )


def classify(model: SymbolModel, features: PatchFeatures) -> list[Classification]:
    """Return each concept group's word for one patch; for many, keep a `Classifier`."""
    return Classifier(model).classify(features)


def group_density(model: SymbolModel, group: Group) -> GroupDensity:
    """Return the densities of a group's words, in their order."""
    columns = model.columns(group.features)
    moments = [model.words[word].moments for word in group.words]
    if model.config.mode is Mode.ROBUST:
        return predictive(moments, columns, model.config.robust.covariance_weight)
    variances = [np.diag(each.scatter)[columns] / max(each.weight, 1.0) for each in moments]
    return density(
        [each.mean[columns] for each in moments],
        [np.diag(np.maximum(variance, 1e-6)) for variance in variances],
        np.full(len(moments), np.inf),
    )


def typicality(group: Group, squared_distance: float) -> float:
    """Return the share of known things that lie farther from their word: a p-value."""
    if not len(group.distances):
        return 0.0
    return float(
        p_values(np.sqrt([squared_distance]), group.distances, dimension=len(group.features))[0]
    )


def unexplained(found: Sequence[Classification]) -> tuple[str, ...]:
    """Return the groups none of whose words explains a patch: what to ask the human about."""
    return tuple(each.group for each in found if not each.known)
