"""The words that the embedded grammar knows, read once from `data/lexicon.toml`."""

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from importlib.resources import files
from itertools import product
from typing import Any, Final

from grounding.language.morphology import Degree, Form, degrees, inflections


class SideRole(StrEnum):
    """What a subordinate clause says of the main one."""

    EARLIER = "earlier"  # it happens before
    LATER = "later"
    REASON = "reason"  # it tells no more than why, or how long
    OCCASION = "occasion"  # a time if it tells what you or I do, a condition otherwise
    CONDITION = "condition"


@dataclass(frozen=True, slots=True, kw_only=True)
class Subordinator:
    """A conjunction that opens a subordinate clause."""

    predicate: str
    role: SideRole


CORRECTION: Final = "or+rather"
"""The conjunction that stands for all ways of taking back what was just said."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Lexicon:
    """Closed classes, nouns, adjectives and verbs with the senses that the ERG gives them.

    Attributes:
        closed: name of a class of function words -> its members.
        starts: name of a class of fixed phrases -> first word -> the phrases, longest first.
        nouns: singular nouns.
        plurals: irregular plural -> singular.
        plural_only: nouns that have no singular.
        invariant: singular nouns that end in s.
        animate: nouns that can receive something.
        openable: nouns that can be opened and closed.
        adjectives: form -> (lemma, degree).
        classes: adjective -> name of the class whose members exclude one another.
        verbs: form -> every (lemma, form) it may be.
        senses: "noun", "adjective" or "verb" and the lemma -> the ERG's sense.
        prepositions: lemma -> predicate where it modifies a noun, and where an event.
        irregular_verbs: lemma -> its past and its participle.
        control: kind of complement -> verbs that bring another verb in that form.
        subordinators: conjunction, its words joined by a plus -> what its clause is.
    """

    closed: Mapping[str, frozenset[str]]
    starts: Mapping[str, Mapping[str, tuple[tuple[str, ...], ...]]]
    nouns: frozenset[str]
    plurals: Mapping[str, str]
    plural_only: frozenset[str]
    invariant: frozenset[str]
    animate: frozenset[str]
    openable: frozenset[str]
    adjectives: Mapping[str, tuple[str, Degree]]
    classes: Mapping[str, str]
    verbs: Mapping[str, tuple[tuple[str, Form], ...]]
    senses: Mapping[tuple[str, str], str]
    prepositions: Mapping[str, tuple[str, str]]
    irregular_verbs: Mapping[str, str]
    control: Mapping[str, frozenset[str]]
    subordinators: Mapping[str, Subordinator]


_CLOSED: Final = (
    "determiners", "demonstratives", "quantities", "cardinals", "ordinals", "particles", "places",
    "adverbs", "interjections", "calls", "results", "units", "conjunctions", "function_words",
    "negations", "fillers", "statives",
)  # fmt: skip
_PHRASES: Final = (
    "phrases", "conjunction_phrases", "without", "leads_base", "leads_gerund", "negation_phrases",
    "asides", "corrections", "hesitations", "tags",
)  # fmt: skip
_CLASSES: Final = ("colour", "size", "weight", "side", "material")


@cache
def lexicon() -> Lexicon:
    """Return the lexicon, read at the first call."""
    table = tomllib.loads(files("grounding.language.data").joinpath("lexicon.toml").read_text())
    nouns, adjectives, verbs = table["nouns"], table["adjectives"], table["verbs"]
    words = table["preposition_words"]
    closed = {name: frozenset(table[name].split()) for name in _CLOSED}
    closed |= {
        "prepositions": frozenset(words["single"].split()),
        "sharpeners": frozenset(words["sharpeners"].split()),
        "dropped": frozenset(words["dropped"].split()),
        "copulas": frozenset(verbs["copulas"].split()),
        "third_argument": frozenset(verbs["third_argument"].split()),
        "recipient": frozenset(verbs["recipient"].split()),
        "particle_sense": frozenset(verbs["particle_sense"]),
        "joined_sense": frozenset(verbs["joined_sense"]),
        "directions": frozenset(table["directions"]),
    }
    return Lexicon(
        closed=closed,
        starts={name: _phrases(table[name]) for name in _PHRASES}
        | {
            "prepositions": _phrases(words["multiple"]),
            "kept": _phrases(words["kept"]),
            "subordinators": _phrases("|".join(table["subordinators"])),
        },
        nouns=frozenset(nouns["words"].split()) | frozenset(table["directions"]),
        plurals=nouns["irregular"],
        plural_only=frozenset(nouns["plural_only"].split()),
        invariant=frozenset(nouns["invariant"].split()),
        animate=frozenset(nouns["animate"].split()),
        openable=frozenset(nouns["openable"].split()),
        adjectives=_adjectives(adjectives),
        classes={word: name for name in _CLASSES for word in adjectives[name].split()},
        verbs=_verbs(verbs, control=table["control"]),
        senses=_senses(table),
        prepositions={word: (pair[0], pair[1]) for word, pair in table["prepositions"].items()},
        irregular_verbs=verbs["irregular"],
        control={kind: frozenset(text.split()) for kind, text in table["control"].items()},
        subordinators={
            words.replace(" ", "+"): Subordinator(predicate=pair[0], role=SideRole(pair[1]))
            for words, pair in table["subordinators"].items()
        },
    )


def _phrases(text: str) -> dict[str, tuple[tuple[str, ...], ...]]:
    """Return first word -> phrases, the longest first, of a list that is separated by bars.

    In a phrase "a/b" stands for either word, and "a?" for a word that may be missing.
    """
    found = [
        tuple(word for word in chosen if word)
        for phrase in text.replace("\n", "|").split("|")
        for chosen in product(*(_alternatives(word) for word in phrase.split()))
    ]
    starts: dict[str, tuple[tuple[str, ...], ...]] = {}
    for words in sorted((words for words in found if words), key=len, reverse=True):
        starts[words[0]] = (*starts.get(words[0], ()), words)
    return starts


def _alternatives(word: str) -> list[str]:
    return [*word.removesuffix("?").split("/"), *([""] if word.endswith("?") else [])]


def _adjectives(table: Mapping[str, Any]) -> dict[str, tuple[str, Degree]]:
    lemmas = " ".join(table[name] for name in (*_CLASSES, "other")).split()
    forms: dict[str, tuple[str, Degree]] = {}
    for lemma in lemmas:
        forms.update(degrees(lemma))
    for form, lemma in table["irregular"].items():
        degree = Degree.COMPARATIVE if form.endswith(("er", "worse")) else Degree.SUPERLATIVE
        forms[form] = (lemma, degree)
    forms.update({lemma: (lemma, Degree.POSITIVE) for lemma in lemmas})
    return forms


def _verbs(
    table: Mapping[str, Any], *, control: Mapping[str, str]
) -> dict[str, tuple[tuple[str, Form], ...]]:
    bringing = " ".join(text for kind, text in control.items() if kind != "modal").split()
    lemmas: Iterable[str] = [*table["other"].split(), *table["irregular"], *bringing]
    forms: dict[str, tuple[tuple[str, Form], ...]] = {}
    for lemma in dict.fromkeys(lemmas):
        for form, kind in inflections(lemma, irregular=table["irregular"].get(lemma, "")):
            forms[form] = (*forms.get(form, ()), (lemma, kind))
    for form, lemma in {"am": "be", "are": "be", "is": "be", "were": "be"}.items():
        forms[form] = ((lemma, Form.PRESENT),)
    forms["has"] = (("have", Form.PRESENT),)
    return forms


def _senses(table: Mapping[str, Any]) -> dict[tuple[str, str], str]:
    senses = {("noun", word): sense for word, sense in table["nouns"]["sense"].items()}
    for word, kind in table["directions"].items():
        senses["noun", word] = kind.removeprefix("n_")
    for kind in ("adjective", "verb"):
        section = table[f"{kind}s"]["sense"]
        senses.update({(kind, word): sense for word, sense in section.items()})
    return senses
