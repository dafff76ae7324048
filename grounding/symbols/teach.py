"""What to ask a person, and what to make of the answer."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from grounding.errors import InputError
from grounding.features.registry import PatchFeatures
from grounding.symbols.classify import Classifier, unexplained_groups
from grounding.symbols.model import SymbolModel
from grounding.symbols.online import NEW_GROUP, update, with_new_word
from grounding.symbols.records import Classification, LabelledPatch


@dataclass(frozen=True, slots=True, kw_only=True)
class Question:
    """A thing that no word of a group explains.

    Attributes:
        group: the group that has no word for it.
        words: the words that it has.
        text: what to ask.
    """

    group: str
    words: tuple[str, ...]
    text: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Taught:
    """The answer was understood.

    Attributes:
        model: what is known now.
        group: the group that the word is in.
    """

    model: SymbolModel
    group: str


@dataclass(frozen=True, slots=True, kw_only=True)
class WhichGroup:
    """The examples do not tell what the word describes.

    Attributes:
        groups: those that it may describe.
    """

    groups: tuple[str, ...]


def questions(model: SymbolModel, found: Sequence[Classification]) -> tuple[Question, ...]:
    """Return what to ask about a patch: one question for each sure group that is at a loss."""
    asked = []
    for name in unexplained_groups(model, found):
        group = model.group_named(name)
        if not group.is_sure or group.kind_of or len(group.words) < 2:
            continue
        text = f"which {name} is this? it is none of: {', '.join(group.words)}"
        asked.append(Question(group=name, words=group.words, text=text))
    return tuple(asked)


def teach(
    model: SymbolModel, word: str, examples: Sequence[PatchFeatures], *, group: str | None = None
) -> Taught | WhichGroup:
    """Learn a word from examples that a person shows; two or three are enough.

    Args:
        model: what is known.
        word: known or new.
        examples: things that bear the word; taken to be right.
        group: what a new word describes; "new" for a name of one thing. None finds out: it is
            the group that does not explain most of the examples.

    Raises:
        InputError: if there is no such group, no example, or none with the group's features.
    """
    if not examples:
        raise InputError("no example shows a thing", where=word, todo="give a patch with a thing")
    names = [each.name for each in model.groups]
    if group is not None and group not in (*names, NEW_GROUP):
        known = ", ".join((*names, NEW_GROUP))
        raise InputError(f"no group {group!r}", where=word, todo=f"name one of: {known}")
    if word not in model.words:
        places = (group,) if group is not None else _places(model, examples)
        if len(places) != 1:
            return WhichGroup(groups=places or (*names, NEW_GROUP))
        model = with_new_word(model, word, places[0])
    kept_before = model.words[word].kept
    for number, features in enumerate(examples):
        patch = LabelledPatch(
            features=features,
            symbols=(word,),
            segment=f"taught {word} {int(model.anything.weight)}.{number}",
        )
        model = update(model, patch, trusted=True)
    holding = model.group_of(word)
    place = holding.name if holding else word
    if model.words[word].kept == kept_before:
        raise InputError(
            f"the examples lack features of {place!r}", where=word, todo="give their mm_per_px"
        )
    return Taught(model=model, group=place)


def _places(model: SymbolModel, examples: Sequence[PatchFeatures]) -> tuple[str, ...]:
    """Return the groups that do not explain most of the examples."""
    classifier = Classifier(model)
    at_a_loss = Counter(
        question.group
        for features in examples
        for question in questions(model, classifier.classify(features))
    )
    return tuple(name for name, count in at_a_loss.items() if 2 * count > len(examples))
