"""From texts to abstract instructions: the one class that the rest of the system calls."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Protocol

from grounding.language.phrases import Phrase, phrases
from grounding.types import Action, Instruction

_PRONOUNS: Final = frozenset({"it", "this", "that", "them"})


@dataclass(frozen=True, slots=True, kw_only=True)
class ParseResult:
    """What one text was understood as.

    Attributes:
        sentence: the text, verbatim.
        backend: name of the backend that parsed it.
        error: why there is no instruction, or None.
        instructions: in the order spoken; empty with an error.
    """

    sentence: str
    backend: str
    error: str | None
    instructions: tuple[Instruction, ...]


class Backend(Protocol):
    """Turns a sentence into its readings."""

    @property
    def name(self) -> str:
        """What a parse says it came from."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Embedded:
    """Our own grammar."""

    name: str = "embedded"


class Parser:
    """Parses texts of a discourse into abstract instructions."""

    def __init__(self, backend: Backend) -> None:
        self._backend = backend

    def parse(self, text: str) -> ParseResult:
        """Return what a text that stands alone says to do."""
        return self.parse_discourse([text])[0]

    def parse_discourse(self, texts: Sequence[str]) -> list[ParseResult]:
        """Return one result for each text; pronouns may refer to earlier texts."""
        said: list[Instruction] = []
        return [self._parse(text, said=said) for text in texts]

    def _parse(self, text: str, *, said: list[Instruction]) -> ParseResult:
        start = len(said)
        for phrase in phrases(text):
            found = _resolved(phrase, said=said)
            if found is None:
                del said[start:]
                break
            said.append(found)
        instructions = tuple(said[start:])
        error = None if instructions else "no instruction was understood"
        return ParseResult(
            sentence=text, backend=self._backend.name, error=error, instructions=instructions
        )


def default_parser() -> Parser:
    """Return the parser with the best backend that is installed."""
    return Parser(Embedded())


def _resolved(phrase: Phrase, *, said: list[Instruction]) -> Instruction | None:
    target, location, source = phrase.target, phrase.location, None
    if target and target[0] in _PRONOUNS:
        if not said:
            return None
        source = len(said) - 1 if said[-1].resolved_from is None else said[-1].resolved_from
        target = said[-1].target
    if not target:
        return None
    symbol = "-".join(location) or "-".join(target) + "-location"
    return Instruction(
        action=Action(phrase.action), target=target, location=symbol, resolved_from=source
    )
