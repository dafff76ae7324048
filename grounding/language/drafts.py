"""Instructions before their pronouns are resolved, and reasons why there is none."""

from dataclasses import dataclass
from enum import StrEnum

from grounding.types import Action


class Reference(StrEnum):
    """What a noun phrase needs to be understood."""

    NAMED = "named"
    PRONOUN = "pronoun"
    NOUN_MISSING = "noun missing"


@dataclass(frozen=True, slots=True, kw_only=True)
class Mention:
    """A noun phrase.

    Attributes:
        words: its symbols; without the noun where that is missing; () for a pronoun.
        noun_at: index of the first noun in `words`.
        reference: what it needs.
        plural: whether it stands for several things.
        text: how it is called in a message.
        unknown: those of its words that the grammar did not know.
    """

    words: tuple[str, ...]
    noun_at: int = 0
    reference: Reference = Reference.NAMED
    plural: bool = False
    text: str = ""
    unknown: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Phrase:
    """A preposition with its landmarks, in spoken order: words and what is still to be resolved."""

    parts: tuple["str | Mention", ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Draft:
    """One command.

    Attributes:
        action: what is done.
        verb: the verb it was said with.
        targets: what it is done to, one instruction each.
        location: the phrases of the location, in order; empty for the target's own.
        relation: the phrases that describe the target.
        background: what was named before in the sentence by what commands nothing.
        held: what of it a pronoun may stand for; never what a denied command named.
        start: where its verb stands in the sentence.
    """

    action: Action
    verb: str
    targets: tuple[Mention, ...]
    location: tuple[Phrase, ...]
    relation: tuple[Phrase, ...]
    background: tuple[Mention, ...] = ()
    held: tuple[Mention, ...] = ()
    start: int = 0


class Reason(StrEnum):
    """Why a sentence gives no instruction; the value is what the user reads."""

    EMPTY = "nothing was said"
    FRAGMENT = "no verb that says what to do was found"
    NOT_UNDERSTOOD = "it is not understood as an instruction"
    TOO_LONG = "it is too long for one sentence; say it in several"
    TOO_MANY = "the text before it is too long; give its sentences one by one"
    STATEMENT = "it states a fact and commands nothing"
    QUESTION = "it asks something and commands nothing"
    NEGATED = "it is a negated command, which is never carried out"
    CHOICE = 'it leaves a choice ("or"); say which one'
    CONDITION = "it depends on a condition; say it again when that holds"
    TAKEN_BACK = "it was taken back"
    NO_OBJECT = "the verb has no object"
    UNKNOWN_VERB = "the verb is not known"
    BACKEND = "the parser failed"
    NO_ANTECEDENT = "there is nothing earlier that it can stand for"


@dataclass(frozen=True, slots=True, kw_only=True)
class Refusal:
    """No instruction, and why.

    Attributes:
        reason: the kind of it.
        message: what the user reads.
        verb: the verb it is about, or "".
        event: the node of that verb, or "".
    """

    reason: Reason
    message: str
    verb: str = ""
    event: str = ""

    @property
    def is_final(self) -> bool:
        """Whether another reading of the sentence must not be tried."""
        return self.reason not in (Reason.FRAGMENT, Reason.NO_OBJECT, Reason.NOT_UNDERSTOOD)

    @property
    def is_silent(self) -> bool:
        """Whether what is refused may be left out beside a command."""
        return self.reason in (Reason.NEGATED, Reason.STATEMENT, Reason.TAKEN_BACK)


def refusal(reason: Reason, *, message: str = "", verb: str = "") -> Refusal:
    """Return a refusal whose message is the reason's own unless another is given."""
    return Refusal(reason=reason, message=message or reason.value, verb=verb)
