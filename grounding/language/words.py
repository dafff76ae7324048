"""Tokens: the words of a sentence with everything that the lexicon says they may be."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

from grounding.language.lexicon import Lexicon, lexicon
from grounding.language.morphology import (
    Degree,
    Form,
    VerbForms,
    inflections,
    singular_candidates,
)
from grounding.language.pieces import Piece, pieces_of
from grounding.language.verbs import VerbTable

_PAUSES: Final = frozenset(",;:-\u2013\u2014/")


@dataclass(frozen=True, slots=True, kw_only=True)
class Token:
    """A word with its span and what it may be; pauses and junk are tokens as well.

    Attributes:
        text: lower-case.
        start: its first character in the sentence.
        end: one past its last.
        noun: its singular where it may be a noun, else "".
        plural: whether it is a plural noun.
        adjective: its positive where it may be an adjective, else "".
        degree: the degree of the adjective.
        verbs: every (lemma, form) it may be.
        closed: names of the classes of function words it belongs to.
        known: whether the lexicon has it.
        capital: whether it is written with a capital.
    """

    text: str
    start: int
    end: int
    noun: str = ""
    plural: bool = False
    adjective: str = ""
    degree: Degree = Degree.POSITIVE
    verbs: tuple[tuple[str, Form], ...] = ()
    closed: frozenset[str] = frozenset()
    known: bool = True
    capital: bool = False

    def is_a(self, name: str) -> bool:
        """Whether the token belongs to a class of function words."""
        return name in self.closed

    def verb(self, form: Form) -> str:
        """Return its lemma as a verb in this form, or ""."""
        return next((lemma for lemma, kind in self.verbs if kind is form), "")


def verb_forms(table: VerbTable) -> VerbForms:
    """Return form -> (lemma, form) of all verbs, those of the table first."""
    known = lexicon()
    forms: dict[str, tuple[tuple[str, Form], ...]] = {}
    for lemma in dict.fromkeys(entry.split()[0] for entry in table.entries):
        for form, kind in inflections(lemma, irregular=known.irregular_verbs.get(lemma, "")):
            forms[form] = (*forms.get(form, ()), (lemma, kind))
    for form, found in known.verbs.items():
        more = tuple(pair for pair in found if pair not in forms.get(form, ()))
        forms[form] = (*forms.get(form, ()), *more)
    return forms


def tokens_of(sentence: str, *, forms: VerbForms) -> list[Token]:
    """Return the tokens of a sentence; brackets, quotes and full stops are left out."""
    found = [_token(piece, forms=forms) for piece in pieces_of(sentence, forms=forms)]
    while found and found[-1].is_a("junk"):
        found.pop()
    return found


def _token(piece: Piece, *, forms: VerbForms) -> Token:
    closed, noun, plural, adjective, degree, known = _analysis(piece.text)
    verbs = forms.get(piece.text, ())
    return Token(
        text=piece.text, start=piece.start, end=piece.end, capital=piece.capital, closed=closed,
        noun=noun, plural=plural, adjective=adjective, degree=degree, verbs=verbs,
        known=known or bool(verbs),
    )  # fmt: skip


@lru_cache(maxsize=8192)
def _analysis(text: str) -> tuple[frozenset[str], str, bool, str, Degree, bool]:
    known = lexicon()
    closed = {name for name, words in known.closed.items() if text in words}
    if text in _PAUSES:
        closed.add("pause")
    elif text.isdigit() or all(part in known.closed["cardinals"] for part in text.split("-")):
        closed.add("cardinals")
    elif not text[0].isalpha():
        closed.add("junk")
    noun, plural = _noun(text, known=known)
    stem = text.removesuffix("-colored").removesuffix("-coloured")
    adjective, degree = known.adjectives.get(stem, ("", Degree.POSITIVE))
    is_known = bool(closed or noun or adjective)
    if not is_known and text.endswith("est") and len(text) > 5:
        adjective, degree = _positive(text[:-3]), Degree.SUPERLATIVE
    return frozenset(closed), noun, plural, adjective, degree, is_known


def _noun(text: str, *, known: Lexicon) -> tuple[str, bool]:
    if text in known.plurals:
        return known.plurals[text], True
    if text in known.nouns or text in known.invariant or text in known.plural_only:
        return text, text in known.plural_only
    for candidate in singular_candidates(text):
        if candidate in known.nouns or candidate in known.invariant:
            return candidate, True
    return "", False


def unknown_noun(text: str) -> tuple[str, bool]:
    """Return the singular of a noun that the lexicon lacks, and whether it was a plural."""
    return next(((lemma, True) for lemma in singular_candidates(text)), (text, False))


def _positive(stem: str) -> str:
    """Return the adjective that an unknown superlative comes from, by its stem."""
    if stem.endswith("i"):
        return stem[:-1] + "y"
    return stem[:-1] if len(stem) > 3 and stem[-1] == stem[-2] and stem[-1] not in "ls" else stem
