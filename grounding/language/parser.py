"""From texts to abstract instructions: the one class that the rest of the system calls."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from delphin.eds import EDS

from grounding.errors import BackendError
from grounding.language.backends.base import Backend
from grounding.language.backends.choose import backend_for
from grounding.language.config import LanguageConfig
from grounding.language.discourse import Discourse
from grounding.language.drafts import Draft, Reason, Refusal, refusal
from grounding.language.sentences import sentences_of
from grounding.language.traverse import traverse
from grounding.language.verbs import VerbTable, default_verbs, with_taught
from grounding.types import Instruction

MAX_CHARACTERS: Final = 1200
MAX_SENTENCES: Final = 600
_ASKING: Final = frozenset(
    {"which", "what", "who", "whose", "where", "why", "how", "is", "are", "was", "were", "does",
     "did", "has", "am"}
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SentenceParse:
    """One sentence of a text.

    Attributes:
        sentence: its words.
        error: why it gives no instruction, or None.
        readings: its EDS, the one that was used first, the rest in the backend's order.
        instructions: what it says to do.
    """

    sentence: str
    error: str | None
    readings: tuple[EDS, ...]
    instructions: tuple[Instruction, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ParseResult:
    """What one text was understood as.

    Attributes:
        sentence: the text, verbatim.
        backend: name of the backend that parsed it.
        error: why there is no instruction, or None.
        instructions: in the order spoken; empty with an error.
        parses: its sentences, each with its own error.
    """

    sentence: str
    backend: str
    error: str | None
    instructions: tuple[Instruction, ...]
    parses: tuple[SentenceParse, ...] = ()


class Parser:
    """Parses texts of a discourse into abstract instructions."""

    def __init__(self, backend: Backend, *, verbs: VerbTable | None = None) -> None:
        self._backend = backend
        self._verbs = verbs or default_verbs()

    @property
    def verbs(self) -> VerbTable:
        """The verbs that it knows."""
        return self._verbs

    def parse(self, text: str) -> ParseResult:
        """Return what a text that stands alone says to do."""
        return self.parse_discourse([text])[0]

    def parse_discourse(self, texts: Sequence[str]) -> list[ParseResult]:
        """Return one result for each text; pronouns may refer to earlier texts.

        `resolved_from` counts the instructions of the whole discourse.
        """
        discourse = Discourse()
        return [self._text(text, discourse=discourse) for text in texts]

    def parse_reading(self, sentence: str, eds: EDS | None) -> ParseResult:
        """Return what one reading, made elsewhere, says to do: the traversal alone."""
        if eds is None:
            return ParseResult(
                sentence=sentence, backend="eds", error=Reason.EMPTY.value, instructions=()
            )
        parse = self._chosen(sentence, readings=[eds], discourse=Discourse())
        return ParseResult(
            sentence=sentence, backend="eds", error=parse.error, instructions=parse.instructions,
            parses=(parse,),
        )  # fmt: skip

    def _text(self, text: str, *, discourse: Discourse) -> ParseResult:
        sentences = sentences_of(text)
        read, rest = sentences[:MAX_SENTENCES], sentences[MAX_SENTENCES:]
        parses = tuple(self._sentence(each, discourse=discourse) for each in read) + tuple(
            _failed(each, why=refusal(Reason.TOO_MANY), readings=()) for each in rest
        )
        instructions = tuple(found for each in parses for found in each.instructions)
        errors = [each.error for each in parses if each.error is not None]
        error = None if instructions else (errors[0] if errors else Reason.EMPTY.value)
        return ParseResult(
            sentence=text, backend=self._backend.name, error=error, instructions=instructions,
            parses=parses,
        )  # fmt: skip

    def _sentence(self, sentence: str, *, discourse: Discourse) -> SentenceParse:
        if len(sentence) > MAX_CHARACTERS:
            return _failed(sentence, why=refusal(Reason.TOO_LONG), readings=())
        try:
            readings = self._backend.readings(sentence)
        except BackendError as error:
            why = refusal(Reason.BACKEND, message=" ".join(str(error).split()))
            return _failed(sentence, why=why, readings=())
        return self._chosen(sentence, readings=readings, discourse=discourse)

    def _chosen(
        self, sentence: str, *, readings: Sequence[EDS], discourse: Discourse
    ) -> SentenceParse:
        """Return what the first reading that gives an instruction says."""
        first: Refusal | None = None
        for i, eds in enumerate(readings):
            found = _traversed(eds, sentence=sentence, verbs=self._verbs)
            result = found if isinstance(found, Refusal) else discourse.understand(found)
            if not isinstance(result, Refusal):
                ordered = (eds, *readings[:i], *readings[i + 1 :])
                return SentenceParse(
                    sentence=sentence, error=None, readings=ordered, instructions=tuple(result)
                )
            first = first or result
            if result.is_final:
                break
        why = first or _why_none(sentence)
        return _failed(sentence, why=why, readings=tuple(readings))


def parser_for(config: LanguageConfig) -> Parser:
    """Return the parser that a configuration asks for.

    Raises:
        ConfigError: if its backend is not installed, or a verb resembles none of the table.
    """
    verbs = with_taught(default_verbs(), pairs=config.verbs.items())
    return Parser(backend_for(config, verbs), verbs=verbs)


def default_parser() -> Parser:
    """Return the parser with the best backend that is installed."""
    return parser_for(LanguageConfig())


def _traversed(eds: EDS, *, sentence: str, verbs: VerbTable) -> list[Draft] | Refusal:
    """Traverse a reading; one that somebody else made may run in a circle."""
    try:
        return traverse(eds, sentence=sentence, verbs=verbs)
    except RecursionError:
        return refusal(Reason.NOT_UNDERSTOOD)


def _failed(sentence: str, *, why: Refusal, readings: tuple[EDS, ...]) -> SentenceParse:
    return SentenceParse(sentence=sentence, error=why.message, readings=readings, instructions=())


def _why_none(sentence: str) -> Refusal:
    """Return why a sentence without any reading commands nothing, as far as its words tell."""
    first = sentence.lower().split()[:1]
    asks = sentence.rstrip().endswith("?") or (bool(first) and first[0] in _ASKING)
    return refusal(Reason.QUESTION if asks else Reason.NOT_UNDERSTOOD)
