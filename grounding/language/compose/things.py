"""The nodes of noun phrases, adjectives and prepositional phrases."""

from collections.abc import Mapping
from typing import Final

from grounding.language.compose.labels import adjective_label, noun_label
from grounding.language.compose.nodes import Nodes, Span
from grounding.language.compose.places import add_place, add_preposition, add_unnamed_place
from grounding.language.grammar.tree import (
    Adjective,
    AdjectivePair,
    Kept,
    Kind,
    Modifier,
    Nominal,
    NounModifier,
    NounPair,
    NounPhrase,
    Number,
    PrepPhrase,
    VerbRelative,
    Word,
)
from grounding.language.lexicon import lexicon
from grounding.language.morphology import Degree
from grounding.language.numerals import CARDINALS, ORDINALS

_QUANTIFIERS: Final = {
    "an": "_a_q", "this": "_this_q_dem", "that": "_that_q_dem", "these": "_these_q_dem",
    "those": "_those_q_dem",
}  # fmt: skip
_OWNERS: Final = {
    "my": "1", "our": "1", "your": "2", "his": "3", "her": "3", "its": "3", "their": "3",
}  # fmt: skip
_PERSONS: Final = {
    "i": ("1", "sg"), "me": ("1", "sg"), "myself": ("1", "sg"), "we": ("1", "pl"),
    "us": ("1", "pl"), "you": ("2", ""), "yourself": ("2", ""), "they": ("3", "pl"),
    "them": ("3", "pl"), "both": ("3", "pl"),
}  # fmt: skip
_GENDERS: Final = {"it": "n", "he": "m", "him": "m", "she": "f", "her": "f"}
_QUANTIFYING_PARTS: Final = frozenset({"all", "some", "each", "both", "no", "none", "neither"})


class Things:
    """Adds noun phrases and what describes them; each method returns the id of the main node.

    Attributes:
        last_landmark: the landmark of the phrase that was added last, if it had one.
    """

    def __init__(self, nodes: Nodes) -> None:
        self._nodes = nodes
        self._words = lexicon()
        self._added: dict[int, str] = {}
        self.last_landmark: str | None = None

    def nominal(self, nominal: Nominal) -> str:
        """Add noun phrases, each once however many verbs share it."""
        known = self._added.get(id(nominal))
        if known is None:
            if isinstance(nominal, NounPhrase):
                known = self._noun_phrase(nominal)
            else:
                known = self._noun_pair(nominal)
            self._added[id(nominal)] = known
        return known

    def silent_subject(self, *, at: Span, person: str) -> str:
        """Add the subject that a command does not say."""
        return self._person(at=at, properties={"PERS": person, "PT": "zero"})

    def attribute(
        self, found: Modifier, *, of: str, properties: Mapping[str, str] | None = None
    ) -> str:
        """Add an adjective that describes a node, with all that belongs to it."""
        if isinstance(found, AdjectivePair):
            word = found.conjunction
            left = self._modifier(found.left, of=of, end=word.start)
            right = self._modifier(found.right, of=of, end=word.end)
            label = "_or_c" if word.lemma == "or" else "_and_c"
            edges = {"ARG1": left, "ARG2": right}
            return self._nodes.event(label, at=word.span, edges=edges, properties=properties)
        if not isinstance(found, Adjective):
            return self._modifier(found, of=of, end=found.word.end)
        label, edges = adjective_label(found.word), {"ARG1": of}
        event = self._nodes.event(label, at=found.word.span, edges=edges, properties=properties)
        self._graded(found, event=event)
        return event

    def phrase(
        self, phrase: PrepPhrase, *, of: str, event: bool = False,
        properties: Mapping[str, str] | None = None,
    ) -> str:  # fmt: skip
        """Add a prepositional phrase that describes a thing or, with `event`, an event."""
        self.last_landmark = None
        if phrase.landmark is not None:
            landmark = self.nominal(phrase.landmark)
            edges = {"ARG1": of, "ARG2": landmark}
            added = add_preposition(
                self._nodes, phrase.word, edges=edges, event=event, properties=properties
            )
            self.last_landmark = landmark
        elif phrase.inner is not None:
            added = self._nested(phrase.word, inner=phrase.inner, of=of, event=event)
        else:
            added = add_place(self._nodes, phrase.word, of=of)
        if phrase.negation is not None:
            self._nodes.event("neg", at=phrase.negation.span, edges={"ARG1": added})
        return added

    def _noun_pair(self, pair: NounPair) -> str:
        left, right = self.nominal(pair.left), self.nominal(pair.right)
        at = (pair.right.start, pair.end) if pair.conjunction is None else pair.conjunction.span
        x = self._nodes.thing(
            _conjunction_label(pair), at=at, edges={"ARG1": left, "ARG2": right},
            properties={"PERS": "3", "NUM": "pl"},
        )  # fmt: skip
        self._nodes.quantifier("udef_q", at=(pair.start, pair.end), of=x)
        return x

    def _noun_phrase(self, noun: NounPhrase) -> str:
        match noun.kind:
            case Kind.PRONOUN:
                return self._pronoun(noun.head)
            case Kind.PART:
                x = self._part(noun)
            case Kind.NUMBER:
                return self._numbered(noun)
            case _:
                x = self._head(noun)
                self._quantifier(noun, of=x)
        for modifier in noun.modifiers:
            self._modifier(modifier, of=x, end=noun.head.end)
        self._complements(noun, of=x)
        return x

    def _head(self, noun: NounPhrase) -> str:
        head = noun.head
        if noun.kind in (Kind.ONE, Kind.DEMONSTRATIVE):
            label = "generic_entity"
        elif noun.kind is Kind.ADJECTIVE:
            label = adjective_label(head)
        else:
            label = noun_label(head)
        x = self._nodes.thing(label, at=head.span, properties=_number(noun))
        if noun.kind is Kind.ONE:
            self._nodes.event("card", at=head.span, edges={"ARG1": x}, carg="1")
        return x

    def _quantifier(self, noun: NounPhrase, *, of: str) -> None:
        word = noun.head if noun.kind is Kind.DEMONSTRATIVE else noun.determiner
        if word is None:
            label = "idiom_q_i" if _is_idiom(noun) else "udef_q"
            self._nodes.quantifier(label, at=(noun.start, noun.end), of=of)
            return
        owner = _OWNERS.get(word.lemma)
        label = _QUANTIFIERS.get(word.lemma, f"_{word.lemma}_q")
        self._nodes.quantifier("def_explicit_q" if owner else label, at=word.span, of=of)
        if word.lemma == "both":
            self._nodes.event("card", at=word.span, edges={"ARG1": of}, carg="2")
        if owner:
            person = self._person(at=word.span, properties={"PERS": owner, "PT": "std"})
            self._nodes.event("poss", at=word.span, edges={"ARG1": of, "ARG2": person})

    def _person(self, *, at: Span, properties: Mapping[str, str]) -> str:
        x = self._nodes.thing("pron", at=at, properties=properties)
        self._nodes.quantifier("pronoun_q", at=at, of=x)
        return x

    def _pronoun(self, head: Word) -> str:
        person, number = _PERSONS.get(head.lemma, ("3", "sg"))
        properties = {"PERS": person, "PT": "std"}
        if number:
            properties["NUM"] = number
        if head.lemma in _GENDERS:
            properties["GEND"] = _GENDERS[head.lemma]
        return self._person(at=head.span, properties=properties)

    def _part(self, noun: NounPhrase) -> str:
        """Add "one of the cubes": a part, whose whole is the cubes."""
        head = noun.head
        edges = {} if noun.of is None else {"ARG1": self.nominal(noun.of)}
        x = self._nodes.thing("part_of", at=head.span, edges=edges, properties=_number(noun))
        if head.lemma in CARDINALS:
            carg = str(CARDINALS.index(head.lemma))
            self._nodes.event("card", at=head.span, edges={"ARG1": x}, carg=carg)
        word, label = head, "udef_q"
        if noun.determiner is not None:
            word = noun.determiner
            label = _QUANTIFIERS.get(word.lemma, f"_{word.lemma}_q")
        elif head.lemma in _QUANTIFYING_PARTS:
            label = f"_{head.lemma}_q"
        self._nodes.quantifier(label, at=word.span, of=x)
        return x

    def _numbered(self, noun: NounPhrase) -> str:
        """Add "cell one", a number whose compound is the noun, or a number alone."""
        head = noun.head
        carg = str(CARDINALS.index(head.lemma)) if head.lemma in CARDINALS else head.lemma
        x = self._nodes.thing("card", at=head.span, properties={"PERS": "3"}, carg=carg)
        self._nodes.quantifier("number_q", at=(noun.start, noun.end), of=x)
        if not noun.modifiers:
            return x
        inner = self._modifier(noun.modifiers[-1], of=x, end=head.end)
        for modifier in noun.modifiers[:-1]:
            self._modifier(modifier, of=inner, end=head.start)
        return x

    def _modifier(self, modifier: Modifier, *, of: str, end: int) -> str:
        match modifier:
            case Number(word=word, value=value, ordinal=ordinal):
                names = ORDINALS if ordinal else CARDINALS
                carg = str(names.index(value)) if value in names else value
                label = "ord" if ordinal else "card"
                return self._nodes.event(label, at=word.span, edges={"ARG1": of}, carg=carg)
            case NounModifier(word=word):
                label = noun_label(word)
                x = self._nodes.thing(label, at=word.span, properties={"PERS": "3"})
                self._nodes.quantifier("udef_q", at=word.span, of=x)
                edges = {"ARG1": of, "ARG2": x}
                self._nodes.event("compound", at=(word.start, end), edges=edges)
                return x
            case _:
                return self.attribute(modifier, of=of)

    def _graded(self, found: Adjective, *, event: str) -> None:
        edges = {"ARG1": event}
        if found.degree is not Degree.POSITIVE:
            label = "superl" if found.degree is Degree.SUPERLATIVE else "more_comp"
            self._nodes.event(label, at=found.word.span, edges=edges)
        if found.intensifier is not None:
            by = found.intensifier
            self._nodes.event(f"_{by.lemma}_x_deg", at=by.span, edges=edges)
        if found.negation is not None:
            self._nodes.event("neg", at=found.negation.span, edges=edges)
        if found.phrase is not None:
            self.phrase(found.phrase, of=event, event=True)

    def _complements(self, noun: NounPhrase, *, of: str) -> None:
        if noun.of is not None and noun.of_word is not None and noun.kind is not Kind.PART:
            whole = self.nominal(noun.of)
            sense = self._words.senses.get(("noun", noun.head.lemma), "")
            if sense.startswith("of") or _is_idiom(noun):
                self._nodes.connect(of, edges={"ARG1": whole})
            else:
                edges = {"ARG1": of, "ARG2": whole}
                self._nodes.event("_of_p", at=noun.of_word.span, edges=edges)
        if noun.owner is not None:
            at, edges = (noun.owner.end, noun.owner.end + 2), {"ARG1": of}
            edges["ARG2"] = self.nominal(noun.owner)
            self._nodes.event("poss", at=at, edges=edges)
        for attribute in noun.after:
            match attribute:
                case PrepPhrase():
                    self.phrase(attribute, of=of)
                case VerbRelative():
                    self._verb_relative(attribute, of=of)
                case _:
                    self.attribute(attribute, of=of)

    def _verb_relative(self, clause: VerbRelative, *, of: str) -> None:
        edges = {"ARG2": of} if clause.passive else {"ARG1": of}
        if clause.subject is not None:
            edges = {"ARG1": self.nominal(clause.subject), "ARG2": of}
        if clause.object is not None:
            edges["ARG3" if "ARG2" in edges else "ARG2"] = self.nominal(clause.object)
        verb = clause.verb
        sense = self._words.senses.get(("verb", verb.lemma), "1")
        label = f"_{verb.lemma}_v_{sense}" if verb.known else f"_{verb.lemma}_v_unknown"
        event = self._nodes.event(label, at=verb.span, edges=edges)
        if clause.particle is not None:
            word = clause.particle
            self._nodes.event(f"_{word.lemma}_p_state", at=word.span, edges={"ARG1": event})
        for phrase in clause.phrases:
            self.phrase(phrase, of=event, event=True)

    def _nested(self, word: Word, *, inner: PrepPhrase, of: str, event: bool) -> str:
        """Add "from under the table" and "over there": the inner phrase tells the place."""
        if inner.landmark is None:
            at = self._nodes.event(f"_{word.lemma}_p_dir", at=word.span, edges={"ARG1": of})
            add_place(self._nodes, inner.word, of=at)
            return at
        place = add_unnamed_place(self._nodes, word)
        self.phrase(inner, of=place)
        edges = {"ARG1": of, "ARG2": place}
        return add_preposition(self._nodes, word, edges=edges, event=event)


def _conjunction_label(pair: NounPair) -> str:
    if pair.kept is Kept.LEFT:
        return "_but+not_c"
    if pair.conjunction is None:
        return "implicit_conj"
    return f"_{pair.conjunction.lemma.replace('&', 'and')}_c"


def _number(noun: NounPhrase) -> dict[str, str]:
    return {"PERS": "3", "NUM": "pl" if noun.plural else "sg"}


def _is_idiom(noun: NounPhrase) -> bool:
    """Whether this is the "top" of "on top of", which has no article."""
    return noun.head.lemma == "top" and noun.determiner is None and not noun.modifiers
