"""A model as JSON: what INTERFACES promises of symbols.json, and the state behind it.

    {"version": 1,
     "symbols": {word: {"features", "mean", "covariance", "kept", "dropped", "group", ...}},
     "groups": {name: [words]},
     "state": {...}}

Means and covariances are in the features' own units over the features that the word's group
describes. `state` holds what a model needs to be read back and to go on learning.
"""

import json
from dataclasses import asdict
from typing import Any, Final

import numpy as np

from grounding.errors import GroundingError, InputError
from grounding.features.registry import features_named
from grounding.symbols.model import Group, Moments, OpenSegment, SymbolModel, Word
from grounding.symbols.records import (
    Mode,
    PaperConfig,
    PatchDecision,
    RobustConfig,
    SymbolConfig,
)
from grounding.types import FloatArray

VERSION: Final = 1

Json = dict[str, Any]  # checked when it is read, in `from_json`


def to_json(model: SymbolModel) -> str:
    """Return the model as the text of symbols.json."""
    document = {
        "version": VERSION,
        "symbols": {word: _symbol(model, word) for word in model.words},
        "groups": {group.name: list(group.words) for group in model.groups},
        "state": _state(model),
    }
    return json.dumps(document, allow_nan=False)


def from_json(text: str, *, where: str) -> SymbolModel:
    """Return the model that a text holds.

    Args:
        text: of a symbols.json.
        where: what to call it in an error.

    Raises:
        InputError: if it is no model, or of another version.
    """
    todo = "fit the model again: gazemap symbols fit LABELS.csv --out MODEL.json"
    try:
        document = json.loads(text)
        version = document["version"]
        model = _model(document) if version == VERSION else None
    except (ValueError, KeyError, TypeError, AttributeError, GroundingError) as error:
        raise InputError(f"not a model of symbols ({error!r})", where=where, todo=todo) from error
    if model is None:
        raise InputError(f"version {version}, expected {VERSION}", where=where, todo=todo)
    return model


def _symbol(model: SymbolModel, word: str) -> Json:
    """Return what is promised of a word, in the features' own units."""
    group = model.group_of(word)
    features = group.features if group else ()
    columns = model.columns(features)
    moments = model.words[word].moments
    unit = model.unit[columns]
    covariance = moments.scatter[np.ix_(columns, columns)] / max(moments.weight, 1.0)
    return {
        "features": list(features),
        "mean": (moments.mean[columns] * unit + model.offset[columns]).tolist(),
        "covariance": (covariance * np.outer(unit, unit)).tolist(),
        "kept": model.words[word].kept,
        "dropped": model.words[word].dropped,
        "group": group.name if group else None,
        "sure": bool(group and group.is_sure),
    }


def _state(model: SymbolModel) -> Json:
    return {
        "config": asdict(model.config),
        "features": list(model.features),
        "offset": model.offset.tolist(),
        "unit": model.unit.tolist(),
        "moments": {name: _moments_json(word.moments) for name, word in model.words.items()},
        "examples": {
            name: [np.round(word.examples, 3).tolist(), np.round(word.strays, 3).tolist()]
            for name, word in model.words.items()
        },
        "anything": _moments_json(model.anything),
        "groups": {
            group.name: {
                "features": list(group.features),
                "distances": group.distances.tolist(),
                "is_sure": group.is_sure,
                "kind_of": group.kind_of,
            }
            for group in model.groups
        },
        "lexicons": model.lexicons,
        "open_segments": [_open_json(each) for each in model.open_segments],
        "decisions": [asdict(decision) for decision in model.decisions],
    }


def _model(document: Json) -> SymbolModel:
    state, symbols = document["state"], document["symbols"]
    config = state["config"]
    features = tuple(map(str, state["features"]))
    features_named(features)
    return SymbolModel(
        config=SymbolConfig(
            mode=Mode(config["mode"]),
            features=tuple(config["features"]),
            robust=RobustConfig(**config["robust"]),
            paper=PaperConfig(**config["paper"]),
        ),
        features=features,
        offset=_array(state["offset"], (len(features),)),
        unit=_array(state["unit"], (len(features),)),
        words={
            name: Word(
                moments=_moments(moments, len(features)),
                kept=int(symbols[name]["kept"]),
                dropped=int(symbols[name]["dropped"]),
                examples=np.array(state["examples"][name][0], float).reshape(-1, len(features)),
                strays=np.array(state["examples"][name][1], float).reshape(-1, len(features)),
            )
            for name, moments in state["moments"].items()
        },
        groups=tuple(
            Group(
                name=name,
                words=tuple(words),
                features=tuple(state["groups"][name]["features"]),
                distances=np.array(state["groups"][name]["distances"], float),
                is_sure=bool(state["groups"][name]["is_sure"]),
                kind_of=str(state["groups"][name]["kind_of"]),
            )
            for name, words in document["groups"].items()
        ),
        anything=_moments(state["anything"], len(features)),
        lexicons={person: dict(words) for person, words in state["lexicons"].items()},
        open_segments=tuple(_open(each, len(features)) for each in state["open_segments"]),
        decisions=tuple(PatchDecision(**each) for each in state["decisions"]),
    )


def _moments_json(moments: Moments) -> Json:
    upper = moments.scatter[np.triu_indices(len(moments.mean))]
    return {
        "weight": moments.weight,
        "effective": moments.effective,
        "mean": moments.mean.tolist(),
        "scatter_upper": upper.tolist(),
    }


def _moments(document: Json, dimension: int) -> Moments:
    upper = np.triu_indices(dimension)
    scatter = np.zeros((dimension, dimension))
    scatter[upper] = _array(document["scatter_upper"], (len(upper[0]),))
    scatter.T[upper] = scatter[upper]
    return Moments(
        weight=float(document["weight"]),
        effective=float(document["effective"]),
        mean=_array(document["mean"], (dimension,)),
        scatter=scatter,
    )


def _open_json(segment: OpenSegment) -> Json:
    return {
        "segment": segment.segment,
        "word": segment.word,
        "patches": segment.patches,
        "log_odds": segment.log_odds,
        "right": segment.right,
        "moments": _moments_json(segment.moments),
    }


def _open(document: Json, dimension: int) -> OpenSegment:
    return OpenSegment(
        segment=str(document["segment"]),
        word=str(document["word"]),
        patches=int(document["patches"]),
        log_odds=float(document["log_odds"]),
        right=float(document["right"]),
        moments=_moments(document["moments"], dimension),
    )


def _array(numbers: list[float], shape: tuple[int, ...]) -> FloatArray:
    array = np.array(numbers, float)
    if array.shape != shape or not np.isfinite(array).all():
        raise ValueError(f"expected {shape} finite numbers, found {array.shape}")
    return array
