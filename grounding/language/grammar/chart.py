"""How rules share their work: each is applied once at each place and keeps its best readings.

A rule is a generator over a chart and a position that yields (what was found, where it ends), the
preferred reading first. Its results are kept, at most `BEAM` of them, so that the work grows with
the number of words however often a rule is asked; no reading is tried twice.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import Final, Generic, TypeVar

from grounding.language.grammar.tree import Word
from grounding.language.lexicon import Lexicon, lexicon
from grounding.language.verbs import VerbTable
from grounding.language.words import Token

BEAM: Final = 8

_END: Final = Token(text="", start=0, end=0)
_PADDING: Final = 8  # more than any rule looks ahead of the end, or behind the start

T = TypeVar("T")
Found = Iterator[tuple[T, int]]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Chart:
    """The tokens of one sentence and what the rules have found in them."""

    tokens: Sequence[Token]
    verbs: VerbTable
    found: dict[tuple[str, int], tuple[tuple[object, int], ...]] = field(default_factory=dict)
    words: Lexicon = field(default_factory=lexicon)
    padded: list[Token] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.padded.extend((*self.tokens, *[_END] * _PADDING))

    def at(self, i: int) -> Token:
        """Return the token at a position; beyond the end and before the start an empty one."""
        try:
            return self.padded[i]
        except IndexError:
            return _END

    def word(self, i: int, *, lemma: str = "", known: bool = True) -> Word:
        """Return the token at a position as a word."""
        token = self.tokens[i]
        return Word(lemma=lemma or token.text, start=token.start, end=token.end, known=known)

    def joined(self, i: int, end: int) -> Word:
        """Return several tokens as one word, joined by a plus."""
        lemma = "+".join(token.text for token in self.tokens[i:end])
        return Word(lemma=lemma, start=self.tokens[i].start, end=self.tokens[end - 1].end)

    def after_phrase(self, i: int, *, name: str) -> int:
        """Return where the longest fixed phrase of a class that starts here ends, or `i`."""
        for words in self.words.starts[name].get(self.at(i).text, ()):
            if all(_same(self.at(i + k).text, word) for k, word in enumerate(words)):
                return i + len(words)
        return i

    def after_correction(self, i: int) -> int:
        """Return where "no, I mean" ends, with the pauses around it, or `i`."""
        j = self.after_pauses(i)
        end = self.after_phrase(j, name="corrections")
        if end == j:
            return i
        while end > j:
            j = self.after_pauses(end)
            end = max(self.after_phrase(j, name=name) for name in ("corrections", "hesitations"))
        return j

    def after_pauses(self, i: int) -> int:
        """Return where the pauses that start here end."""
        while self.at(i).is_a("pause"):
            i += 1
        return i


def _same(text: str, word: str) -> bool:
    return text == word or (word == "is" and text == "'s")


class Rule(Generic[T]):
    """A named rule that is declared before it is defined, for rules call one another in circles."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._body: Callable[[Chart, int], Found[T]] | None = None

    def define(self, body: Callable[[Chart, int], Found[T]]) -> Callable[[Chart, int], Found[T]]:
        """Give the rule its body."""
        self._body = body
        return body

    def __call__(self, chart: Chart, i: int) -> tuple[tuple[T, int], ...]:
        """Return the readings at a position, the preferred first."""
        key = (self._name, i)
        kept = chart.found.get(key)
        if kept is None:
            if self._body is None:
                raise LookupError(self._name)
            kept = chart.found[key] = tuple(islice(self._body(chart, i), BEAM))
        return kept  # type: ignore[return-value] # the key names the rule, which fixes the type
