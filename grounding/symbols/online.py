"""Learn on: each new patch updates its words in constant time, and words can be forgotten.

This is incremental expectation maximisation (Neal and Hinton 1998): the label of the patch's
segment is weighed anew, what the segment had added to its word is taken back, and what it adds
now is put in. Concept groups stay as they were fitted. A fit of all patches at once differs only
in what it believes of segments that arrived early: `docs/symbols.md` states how much.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from grounding.errors import InputError
from grounding.features.registry import PatchFeatures
from grounding.symbols.calibration import with_one_more
from grounding.symbols.classify import Classifier, know_group, unexplained_groups
from grounding.symbols.compounds import expanded, head_of
from grounding.symbols.model import (
    MAX_EXAMPLES,
    Group,
    Moments,
    OpenSegment,
    SymbolModel,
    Word,
)
from grounding.symbols.records import LabelledPatch, Mode
from grounding.symbols.robust import (
    influence_of,
    label_log_odds,
    label_right,
    patch_logs,
    tempering,
    typicality,
)
from grounding.types import FloatArray

_MAX_OPEN: Final = 24
_BELIEVED: Final = 0.5
NEW_GROUP: Final = "new"


def update(model: SymbolModel, patch: LabelledPatch, *, trusted: bool = False) -> SymbolModel:
    """Return the model after one more patch.

    A word that is new joins the group that does not explain the patch.

    Args:
        model: in `robust` mode.
        patch: with its words; one without an object only counts as dropped, and so it does for a
            word that describes a feature which could not be measured.
        trusted: the label is known to be right, as when a person shows a thing.

    Raises:
        InputError: if the model was fitted in `paper` mode, which has no learning on.
    """
    if model.config.mode is not Mode.ROBUST:
        raise InputError(
            "a model of mode 'paper' cannot learn on", where="model", todo="fit robust"
        )
    words = expanded(patch.symbols)
    sample = model.scale(patch.features) if isinstance(patch.features, PatchFeatures) else None
    if sample is None:
        return _dropped(model, words)
    for word in words:
        if word not in model.words:
            model = with_new_word(model, word, _place_for(model, word, patch))
        whole = _completed(model, word, sample)
        model = (
            _dropped(model, (word,))
            if whole is None
            else _learn(model, word, whole, patch, trusted=trusted)
        )
    whole = np.where(np.isfinite(sample), sample, model.anything.mean)
    return replace(model, anything=model.anything.plus(Moments.single(whole, patch.weight)))


def with_new_word(model: SymbolModel, word: str, group: str) -> SymbolModel:
    """Return the model with a word of which nothing is known yet.

    Args:
        model: what is known.
        word: the new word.
        group: the group that it joins; "new" makes it one of its own, a name for one thing.
    """
    nothing = np.empty((0, len(model.features)))
    empty = Word(
        moments=Moments.none(len(model.features)),
        kept=0,
        dropped=0,
        examples=nothing,
        strays=nothing,
    )
    words = {**model.words, word: empty}
    names = [each.name for each in model.groups]
    if group in names:
        grown = [
            replace(each, words=tuple(sorted((*each.words, word)))) if each.name == group else each
            for each in model.groups
        ]
        return replace(model, words=words, groups=tuple(grown))
    own = Group(
        name=word if word not in names else f"{word}-2",
        words=(word,),
        features=model.features,
        distances=_common_distances(model),
        is_sure=True,
        kind_of=head_of(word) or "",
    )
    return replace(model, words=words, groups=(*model.groups, own))


def forget(model: SymbolModel, word: str) -> SymbolModel:
    """Return the model without a word, its segments, and what people called by it.

    Raises:
        InputError: if the word is not known.
    """
    if word not in model.words:
        known = ", ".join(sorted(model.words))
        raise InputError(f"no word {word!r}", where="model", todo=f"name one of: {known}")
    groups = [
        replace(group, words=tuple(each for each in group.words if each != word))
        for group in model.groups
    ]
    return replace(
        model,
        words={name: each for name, each in model.words.items() if name != word},
        groups=tuple(group for group in groups if group.words),
        open_segments=tuple(each for each in model.open_segments if each.word != word),
        decisions=tuple(each for each in model.decisions if each.symbol != word),
        lexicons={
            person: {own: meaning for own, meaning in lexicon.items() if meaning != word}
            for person, lexicon in model.lexicons.items()
        },
    )


def _completed(model: SymbolModel, word: str, sample: FloatArray) -> FloatArray | None:
    """Return a sample (D,) whose missing features are as expected of a word, or None.

    Without a metric scale sizes are missing: that is no matter to a colour, but to a shape it is.
    """
    missing = ~np.isfinite(sample)
    if not missing.any():
        return sample
    group = model.group_of(word)
    if group is None or missing[model.columns(group.features)].any():
        return None
    known = model.words[word].moments
    expected = known if known.weight > 0 else model.anything
    return np.where(missing, expected.mean, sample)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Weighed:
    """What is made of a patch before it is learnt from."""

    log_odds: float = 0.0
    typical: float = 1.0
    influence: float = 1.0
    squared: float | None = None


def _learn(
    model: SymbolModel, word: str, sample: FloatArray, patch: LabelledPatch, *, trusted: bool
) -> SymbolModel:
    """Return the model with a patch added to one word."""
    group = model.group_of(word)
    if group is None:
        return model
    segments = [s for s in model.open_segments if (s.segment, s.word) == (patch.segment, word)]
    before = segments[0] if segments else _opened(patch.segment, word, len(sample))
    without = _with_word(model, word, before.moments.scaled(-before.right))
    weighed = _weigh(without, group, word, sample)
    config = model.config.robust
    count, log_odds = before.patches + 1, before.log_odds + weighed.log_odds * patch.weight
    temper = tempering(count, config)
    own = before.moments.plus(Moments.single(sample, patch.weight * weighed.influence))
    after = OpenSegment(
        segment=patch.segment,
        word=word,
        patches=count,
        log_odds=log_odds,
        right=1.0 if trusted else _right(log_odds * temper, config.wrong_rate),
        moments=replace(own, effective=own.weight * temper),
    )
    is_believed = after.right > _BELIEVED
    told = _told(without.words[word], before, after, sample)
    if is_believed and weighed.typical > _BELIEVED and weighed.squared is not None:
        model = _calibrated(model, group, float(np.sqrt(weighed.squared)))
    others = tuple(s for s in model.open_segments if s not in segments)
    return replace(
        model,
        words={**model.words, word: told},
        open_segments=(*others, after)[-_MAX_OPEN:],
    )


def _opened(segment: str, word: str, dimension: int) -> OpenSegment:
    return OpenSegment(
        segment=segment,
        word=word,
        patches=0,
        log_odds=0.0,
        right=0.0,
        moments=Moments.none(dimension),
    )


def _weigh(model: SymbolModel, group: Group, word: str, sample: FloatArray) -> _Weighed:
    """Weigh a patch by what was known before its segment; a new word knows nothing yet."""
    known = know_group(model, group)
    if known is None or word not in known.words:
        return _Weighed()
    config, place = model.config.robust, known.words.index(word)
    chosen = sample[None, known.columns]
    squared = float(known.density.squared_distances(chosen)[0, place])
    logs = patch_logs(chosen, known.density, known.columns, model.anything, config)
    typical = typicality(np.array([squared]), chosen.shape[1], config)
    log_odds = label_log_odds(logs, np.array([place]))
    influence = influence_of(typical) if group.is_sure else typical
    return _Weighed(
        log_odds=float(log_odds[0]),
        typical=float(typical[0]),
        influence=float(influence[0]),
        squared=squared,
    )


def _right(log_odds: float, wrong_rate: float) -> float:
    return float(label_right(np.array([log_odds]), wrong_rate)[0])


def _with_word(model: SymbolModel, word: str, moments: Moments) -> SymbolModel:
    """Return the model with moments added to a word; negative weights take them back."""
    known = model.words[word]
    return replace(
        model, words={**model.words, word: replace(known, moments=known.moments.plus(moments))}
    )


def _told(word: Word, before: OpenSegment, after: OpenSegment, sample: FloatArray) -> Word:
    """Return a word, from which a segment was taken, with the segment after one more patch.

    The patch is among those to show in pictures, from which the oldest leave.
    """
    was, now = before.right > _BELIEVED, after.right > _BELIEVED
    shown = (word.examples if now else word.strays).reshape(-1, len(sample))
    shown = np.vstack([shown, sample])[-MAX_EXAMPLES:]
    return Word(
        moments=word.moments.plus(after.moments.scaled(after.right)),
        kept=max(0, word.kept - before.patches * was + after.patches * now),
        dropped=max(0, word.dropped - before.patches * (not was) + after.patches * (not now)),
        examples=shown if now else word.examples,
        strays=word.strays if now else shown,
    )


def _calibrated(model: SymbolModel, group: Group, distance: float) -> SymbolModel:
    """Return the model with one more distance of a known patch from its word."""
    distances = with_one_more(group.distances, distance, int(model.anything.weight))
    groups = tuple(
        replace(each, distances=distances) if each.name == group.name else each
        for each in model.groups
    )
    return replace(model, groups=groups)


def _place_for(model: SymbolModel, word: str, patch: LabelledPatch) -> str:
    """Return the group that a new word joins: the one that neither explains nor names the thing."""
    head = head_of(word)
    if head is not None:
        kinds = [each.name for each in model.groups if each.kind_of == head]
        return kinds[0] if kinds else NEW_GROUP
    if not isinstance(patch.features, PatchFeatures):
        return NEW_GROUP
    named = {each.name for each in model.groups if set(each.words) & set(patch.symbols)}
    missing = [
        name
        for name in unexplained_groups(model, Classifier(model).classify(patch.features))
        if name not in named and not model.group_named(name).kind_of
    ]
    return missing[0] if len(missing) == 1 else NEW_GROUP


def _common_distances(model: SymbolModel) -> FloatArray:
    """Return the distances of the best known group, for one of which nothing is known yet."""
    return max((group.distances for group in model.groups), key=len, default=np.empty(0))


def _dropped(model: SymbolModel, words: tuple[str, ...]) -> SymbolModel:
    known = {
        name: replace(each, dropped=each.dropped + 1) if name in words else each
        for name, each in model.words.items()
    }
    return replace(model, words=known)
