"""What the words say of a plan that the gaze has grounded: contradictions, and words to ask for."""

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from grounding.features.background import NoObject
from grounding.features.registry import Family, extract_features, features_named
from grounding.patches.patch import Patch
from grounding.plan import GroundedInstruction, GroundedPlan, Status
from grounding.symbols.classify import Classifier
from grounding.symbols.model import Group, SymbolModel

_LEAST_PATCHES = 3
_LEAST_THINGS = 2  # others that a word is known by
_MAJORITY = 2 / 3


def heed_words(plan: GroundedPlan, patches: Sequence[Patch], symbols: SymbolModel) -> GroundedPlan:
    """Return the plan with each status as the words' learnt meanings allow.

    A target that mostly looks like another word of the same concept group is not sure any more, if
    the word that was said is known: other things that are called so look like it, and none does
    not. A target that is not found and has a word nobody has shown yet becomes a question.

    Args:
        plan: as the gaze has it.
        patches: of its targets.
        symbols: what the words mean, learnt from all of the session's patches.
    """
    classifier = Classifier(symbols)
    flat = frozenset(group.name for group in symbols.groups if _is_of_colour(group))
    things: dict[str, _Thing] = {}
    for each in plan.instructions:
        if each.status is Status.GROUNDED:
            thing = things.setdefault(_name(each), _Thing())
            thing.said.update(each.spoken.instruction.target)
            thing.patches += [p for p in patches if p.instruction == each.spoken.index]
    for thing in things.values():
        thing.heard = _heard(thing.patches, classifier, flat=flat)
    instructions = tuple(_heeded(each, things, symbols) for each in plan.instructions)
    return dataclasses.replace(plan, instructions=instructions)


@dataclass(slots=True, kw_only=True, eq=False)
class _Thing:
    """A thing that instructions are grounded in.

    Attributes:
        said: all words that it was called by.
        patches: its pictures.
        heard: for each concept group the word that they look like.
    """

    said: set[str] = field(default_factory=set)
    patches: list[Patch] = field(default_factory=list)
    heard: Mapping[str, str] = field(default_factory=dict)


def _name(each: GroundedInstruction) -> str:
    """Return the name of an instruction's thing; what vision has no instance of stands alone."""
    found = each.target.object_id if each.target is not None else None
    return found or f"of instruction {each.spoken.index}"


def _is_known(word: str, group: str, others: Sequence[_Thing]) -> bool:
    """Return whether other things that are called so look like it, and none looks otherwise."""
    called = [each for each in others if word in each.said and group in each.heard]
    is_right = [each.heard[group] in each.said for each in called]
    return sum(is_right) >= _LEAST_THINGS and all(is_right)


def _is_of_colour(group: Group) -> bool:
    """Return whether a group's words are about colour alone."""
    return {feature.family for feature in features_named(group.features)} == {Family.COLOUR}


def _heard(
    patches: Sequence[Patch], classifier: Classifier, *, flat: frozenset[str]
) -> Mapping[str, str]:
    """Return for each concept group the word that most of a thing's patches bear.

    Seen aslant from the head a thing shows its sides too: only its colour is heeded, group `flat`.
    """
    votes: dict[str, dict[str, int]] = {}
    count = 0
    for each in patches:
        if not each.kept or each.image_bgr is None:
            continue
        features = extract_features(
            each.image_bgr, mm_per_px=each.mm_per_px, height_mm=each.height_mm
        )
        if isinstance(features, NoObject):
            continue
        count += 1
        for found in classifier.classify(features):
            if found.known and (found.group in flat or each.camera != "head"):
                group = votes.setdefault(found.group, {})
                group[found.symbol] = group.get(found.symbol, 0) + 1
    if count < _LEAST_PATCHES:
        return {}
    return {
        group: max(words, key=lambda word: words[word])
        for group, words in votes.items()
        if max(words.values()) >= _MAJORITY * count
    }


def _heeded(
    each: GroundedInstruction, things: Mapping[str, _Thing], symbols: SymbolModel
) -> GroundedInstruction:
    said = each.spoken.instruction.target
    if each.status is Status.UNGROUNDED and each.start_ns is not None and each.target is None:
        unknown = [word for word in said if word not in symbols.words]
        return _asking(each, unknown[0]) if unknown and symbols.words else each
    if each.status is not Status.GROUNDED:
        return each
    heard = things[_name(each)].heard
    others = [thing for name, thing in things.items() if name != _name(each)]
    for group in symbols.groups:
        mine = [word for word in said if word in group.words]
        looks_like = heard.get(group.name)
        if looks_like is None or not mine or looks_like in mine:
            continue
        if _is_known(mine[0], group.name, others):
            return _contradicted(each, said=mine[0], looks_like=looks_like)
    return each


def _asking(each: GroundedInstruction, word: str) -> GroundedInstruction:
    return dataclasses.replace(
        each,
        status=Status.UNKNOWN_SYMBOL,
        question=f"What does '{word}' mean? Please show me one.",
        reason=f"unknown: {word}",
    )


def _contradicted(each: GroundedInstruction, *, said: str, looks_like: str) -> GroundedInstruction:
    return dataclasses.replace(
        each,
        status=Status.AMBIGUOUS,
        confidence=min(each.confidence, 0.5),
        candidates=(each.target,) if each.target is not None else (),
        question=f"Is this one '{said}'? It looks like '{looks_like}' to me.",
        reason=f"what was looked at is not '{said}' but '{looks_like}', as learnt from the rest",
    )
