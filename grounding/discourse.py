"""What was said in a session, as the numbered instructions of one discourse."""

from collections.abc import Sequence
from dataclasses import dataclass

from grounding.language.parser import Parser
from grounding.plan import Unparsed
from grounding.types import SpokenInstruction


@dataclass(frozen=True, slots=True, kw_only=True)
class Utterance:
    """Something that was said; the times are the transcript's, or None."""

    text: str
    start_ns: int | None
    end_ns: int | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Discourse:
    """The instructions of a session in the order said, and the sentences that gave none."""

    spoken: tuple[SpokenInstruction, ...]
    unparsed: tuple[Unparsed, ...]


def understand(utterances: Sequence[Utterance], parser: Parser) -> Discourse:
    """Parse all utterances as one discourse and number their instructions through it."""
    parses = parser.parse_discourse([each.text for each in utterances])
    spoken: list[SpokenInstruction] = []
    for said, parse in zip(utterances, parses, strict=True):
        spoken += [
            SpokenInstruction(
                index=len(spoken) + k,
                sentence=parse.sentence,
                instruction=each,
                said_start_ns=said.start_ns,
                said_end_ns=said.end_ns,
            )
            for k, each in enumerate(parse.instructions)
        ]
    unparsed = tuple(
        Unparsed(sentence=each.sentence, reason=each.error)
        for parse in parses
        for each in parse.parses
        if each.error is not None
    )
    return Discourse(spoken=tuple(spoken), unparsed=unparsed)
