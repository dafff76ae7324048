"""The pieces of a sentence: where its words begin and end, contractions taken apart."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

from grounding.language.lexicon import lexicon
from grounding.language.morphology import Form, VerbForms
from grounding.language.numerals import ORDINALS

_PIECE: Final = re.compile(r"[^\W_]+(?:[-'][^\W_]+)*|\S")
_LIST_MARK: Final = re.compile(r"\s*(?:\(?\d{1,2}\s*[).:]|[-*•])\s+")
_SKIPPED: Final = frozenset("\"[]{}<>*`“”«»'!?.…")
_WRITTEN_OUT: Final = {"/": "or", "(": ",", ")": ","}
_CLITIC: Final = re.compile(r"(n't|'s|'m|'re|'ll|'ve|'d)$")
_NUMBERED: Final = re.compile(r"(\d{1,2})(?:st|nd|rd|th)")
_JOINED: Final = re.compile(r"([a-z]+?)-?(up|down|over|away|out|off)")
_FUSED: Final = {
    "cannot": ("can", "not"), "cant": ("can", "not"), "dont": ("do", "not"),
    "gonna": ("going", "to"), "wanna": ("want", "to"), "gotta": ("have", "to"),
    "lets": ("let", "'s"), "lemme": ("let", "me"), "gimme": ("give", "me"),
}  # fmt: skip
_FULL: Final = {"n't": "not", "'m": "am", "'re": "are", "'ll": "will", "'ve": "have", "'d": "would"}
_STEMS: Final = {"ca": "can", "wo": "will", "sha": "shall"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Piece:
    """A word, a part of one, or a mark, with its span.

    Attributes:
        text: lower-case, written out in full.
        start: its first character in the sentence.
        end: one past its last.
        capital: whether it is written with a capital.
    """

    text: str
    start: int
    end: int
    capital: bool = False


def pieces_of(sentence: str, *, forms: VerbForms) -> Iterator[Piece]:
    """Yield the pieces of a sentence without brackets, quotes, full stops and a list's mark."""
    sentence = sentence.replace("\u2019", "'")
    mark = _LIST_MARK.match(sentence)
    before = ""
    for match in _PIECE.finditer(sentence, mark.end() if mark else 0):
        if match[0] in _SKIPPED:
            continue
        whole = Piece(
            text=match[0].lower(), start=match.start(), end=match.end(),
            capital=match[0][0].isupper(),
        )  # fmt: skip
        verb_may_stand = before not in lexicon().closed["determiners"]
        yield from _parts(whole, forms=forms if verb_may_stand else {})
        before = whole.text


def _parts(whole: Piece, *, forms: VerbForms) -> Iterator[Piece]:
    """Yield what a piece says: "won't" is will not, "2nd" is second, "pickup" is pick up."""
    text = whole.text
    if text in _WRITTEN_OUT:
        yield replace(whole, text=_WRITTEN_OUT[text])
        return
    clitic, numbered = _CLITIC.search(text), _NUMBERED.fullmatch(text)
    joined = _JOINED.fullmatch(text)
    if text in _FUSED:
        first, second = _FUSED[text]
        yield Piece(text=first, start=whole.start, end=whole.end, capital=whole.capital)
        yield Piece(text=second, start=whole.start, end=whole.end)
    elif clitic and clitic.start() > 0:
        stem, middle = text[: clitic.start()], whole.start + clitic.start()
        full = _STEMS.get(stem, stem)
        yield Piece(text=full, start=whole.start, end=middle, capital=whole.capital)
        yield Piece(text=_FULL.get(clitic[0], clitic[0]), start=middle, end=whole.end)
    elif numbered and int(numbered[1]) < len(ORDINALS):
        yield Piece(text=ORDINALS[int(numbered[1])], start=whole.start, end=whole.end)
    elif joined and any(form is Form.BASE for _, form in forms.get(joined[1], ())):
        middle = whole.start + joined.start(2)
        yield Piece(text=joined[1], start=whole.start, end=middle, capital=whole.capital)
        yield Piece(text=joined[2], start=middle, end=whole.end)
    else:
        yield whole
