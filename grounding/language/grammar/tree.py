"""The syntax tree that the grammar builds and that is composed into an EDS."""

from dataclasses import dataclass
from enum import StrEnum

from grounding.language.morphology import Degree, Form


@dataclass(frozen=True, slots=True, kw_only=True)
class Word:
    """A lemma with its span in the sentence."""

    lemma: str
    start: int
    end: int
    known: bool = True

    @property
    def span(self) -> tuple[int, int]:
        """Its first character and one past its last."""
        return self.start, self.end


@dataclass(frozen=True, slots=True, kw_only=True)
class Adjective:
    """An adjective with what it takes along: "very", "closest to the box", "bigger than it"."""

    word: Word
    degree: Degree = Degree.POSITIVE
    intensifier: Word | None = None
    phrase: "PrepPhrase | None" = None
    negation: Word | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class AdjectivePair:
    """Two adjectives with a conjunction: "red and blue"."""

    conjunction: Word
    left: "Modifier"
    right: "Modifier"


@dataclass(frozen=True, slots=True, kw_only=True)
class Number:
    """An ordinal or a cardinal before a noun."""

    word: Word
    value: str
    ordinal: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class NounModifier:
    """A noun that modifies the next: the "steak" of "steak knife"."""

    word: Word


Modifier = Adjective | AdjectivePair | Number | NounModifier


class Kind(StrEnum):
    """What the head of a noun phrase is."""

    NOUN = "noun"
    PRONOUN = "pronoun"
    DEMONSTRATIVE = "demonstrative"
    ONE = "one"
    ADJECTIVE = "adjective"
    NUMBER = "number"
    PART = "part"


@dataclass(frozen=True, slots=True, kw_only=True)
class NounPhrase:
    """A noun phrase; for a PART ("two of the cubes") `of` holds the whole."""

    kind: Kind
    head: Word
    start: int
    end: int
    plural: bool = False
    determiner: Word | None = None
    modifiers: tuple[Modifier, ...] = ()
    of: "Nominal | None" = None
    of_word: Word | None = None
    owner: "NounPhrase | None" = None
    after: "tuple[Adjective | AdjectivePair | PrepPhrase | VerbRelative, ...]" = ()


class Kept(StrEnum):
    """Which of two noun phrases are meant."""

    BOTH = "both"
    LEFT = "left"  # "this, but not that"
    RIGHT = "right"  # "not this but that", "this, no, that"


@dataclass(frozen=True, slots=True, kw_only=True)
class NounPair:
    """Two noun phrases with a conjunction, or none in a list."""

    conjunction: Word | None
    left: "Nominal"
    right: "Nominal"
    start: int
    end: int
    kept: Kept = Kept.BOTH


Nominal = NounPhrase | NounPair


@dataclass(frozen=True, slots=True, kw_only=True)
class PrepPhrase:
    """A preposition with its landmark, or an adverb of place without one.

    Attributes:
        word: the preposition; several words are joined by a plus.
        landmark: what it takes; None for "inside" and "there".
        inner: a phrase in place of the landmark: "from under the table".
        negation: "not", where it is denied.
        joined: the conjunction that ties it to the phrase before: "on the tray and next to it".
    """

    word: Word
    landmark: Nominal | None = None
    inner: "PrepPhrase | None" = None
    negation: Word | None = None
    joined: Word | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class VerbRelative:
    """A relative clause with a verb: "that you put on the tray", "lying on the table"."""

    verb: Word
    particle: Word | None
    subject: NounPhrase | None
    phrases: tuple[PrepPhrase, ...]
    passive: bool
    object: NounPhrase | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Adverb:
    """An adverb, a marker of discourse or a polite word."""

    word: Word


@dataclass(frozen=True, slots=True, kw_only=True)
class VerbPhrase:
    """A verb with its object, recipient and phrases.

    Attributes:
        verb: the lemma.
        form: the form it has.
        end: where the phrase ends.
        particle: "up" in "pick up".
        joined: whether the particle stands at the verb.
        object: what is acted on.
        recipient: who gets it, without a preposition.
        fronted: phrases before the verb.
        phrases: phrases behind it.
        adverbs: everything else.
        passive: whether `object` is its surface subject.
    """

    verb: Word
    form: Form
    end: int
    particle: Word | None = None
    joined: bool = False
    object: Nominal | None = None
    recipient: NounPhrase | None = None
    fronted: tuple[PrepPhrase, ...] = ()
    phrases: tuple[PrepPhrase, ...] = ()
    adverbs: tuple[Adverb, ...] = ()
    passive: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Control:
    """A verb that brings another: "could", "try to", "would like you to".

    Attributes:
        verb: its lemma; None where it has no predicate ("am taking", "do").
        modal: whether it is a modal.
        person: whom it is asked of, where that is said.
        body: what it brings.
    """

    verb: Word | None
    modal: bool
    person: NounPhrase | None
    body: "Predicate"


@dataclass(frozen=True, slots=True, kw_only=True)
class Negation:
    """A denied predicate."""

    word: Word
    body: "Predicate"


@dataclass(frozen=True, slots=True, kw_only=True)
class PredicatePair:
    """Two predicates in order, with a conjunction or run on."""

    conjunction: Word | None
    left: "Predicate"
    right: "Predicate"


Predicate = VerbPhrase | Control | Negation | PredicatePair


class Mood(StrEnum):
    """What a clause does."""

    COMMAND = "comm"
    STATEMENT = "prop"
    QUESTION = "ques"


@dataclass(frozen=True, slots=True, kw_only=True)
class Clause:
    """A predicate with its subject and mood, and what was said around it."""

    mood: Mood
    predicate: Predicate
    subject: Nominal | None
    adverbs: tuple[Adverb, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Description:
    """A clause that says or asks what is: its subject and what is said of it, if anything."""

    mood: Mood
    subject: Nominal
    said: "Adjective | AdjectivePair | PrepPhrase | Nominal | None"
    verb: Word


@dataclass(frozen=True, slots=True, kw_only=True)
class Fragment:
    """A noun phrase that stands alone."""

    nominal: Nominal


@dataclass(frozen=True, slots=True, kw_only=True)
class ClausePair:
    """Two clauses in order."""

    conjunction: Word | None
    left: "Sentence"
    right: "Sentence"


@dataclass(frozen=True, slots=True, kw_only=True)
class Subordination:
    """A sentence with a clause that says when, why or on what condition it holds."""

    word: Word
    main: "Sentence"
    side: "Sentence"


Sentence = Clause | Description | Fragment | ClausePair | Subordination
