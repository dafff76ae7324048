"""What the grounding service says, asks and answers: documents with a version around them."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from gazemap.errors import InputError
from gazemap.wire.envelope import SCHEMA_VERSION, parse
from gazemap.wire.generated import gazemap_grounding_pb2 as pb
from gazemap.wire.streams import Stream

# A JSON object as the commands print it and the rebuild writes it.
Document = Mapping[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanMessage:
    """The whole plan; a higher revision replaces all before it."""

    t_ns: int
    revision: int
    plan: Document


@dataclass(frozen=True, slots=True, kw_only=True)
class InstructionMessage:
    """One instruction of the plan, as it settles or is corrected."""

    t_ns: int
    revision: int
    index: int
    instruction: Document


@dataclass(frozen=True, slots=True, kw_only=True)
class SymbolsMessage:
    """What every word means so far."""

    t_ns: int
    symbols: Document


NO_INSTRUCTION: Final = -1


@dataclass(frozen=True, slots=True, kw_only=True)
class Question:
    """What the human is asked about a thing whose word is not known.

    `instruction_index` is `NO_INSTRUCTION` where none was about the thing.
    """

    t_ns: int
    instruction_index: int
    text: str
    words: tuple[str, ...]
    object_id: str | None


def encode_plan(message: PlanMessage) -> bytes:
    """Return the message of `plan`."""
    return pb.Plan(
        version=SCHEMA_VERSION,
        t_ns=message.t_ns,
        revision=message.revision,
        json=_text(message.plan),
    ).SerializeToString()


def decode_plan(payload: bytes) -> PlanMessage:
    """Read a message of `plan`."""
    message = parse(pb.Plan(), payload, stream=Stream.PLAN)
    return PlanMessage(
        t_ns=message.t_ns,
        revision=message.revision,
        plan=document_of(message.json, stream=Stream.PLAN),
    )


def encode_instruction(message: InstructionMessage) -> bytes:
    """Return the message of `instruction`."""
    return pb.Instruction(
        version=SCHEMA_VERSION,
        t_ns=message.t_ns,
        revision=message.revision,
        index=message.index,
        json=_text(message.instruction),
    ).SerializeToString()


def decode_instruction(payload: bytes) -> InstructionMessage:
    """Read a message of `instruction`."""
    message = parse(pb.Instruction(), payload, stream=Stream.INSTRUCTION)
    return InstructionMessage(
        t_ns=message.t_ns,
        revision=message.revision,
        index=message.index,
        instruction=document_of(message.json, stream=Stream.INSTRUCTION),
    )


def encode_symbols(message: SymbolsMessage) -> bytes:
    """Return the message of `symbols`."""
    return pb.Symbols(
        version=SCHEMA_VERSION, t_ns=message.t_ns, json=_text(message.symbols)
    ).SerializeToString()


def decode_symbols(payload: bytes) -> SymbolsMessage:
    """Read a message of `symbols`."""
    message = parse(pb.Symbols(), payload, stream=Stream.SYMBOLS)
    return SymbolsMessage(
        t_ns=message.t_ns, symbols=document_of(message.json, stream=Stream.SYMBOLS)
    )


def encode_question(question: Question) -> bytes:
    """Return the message of `question`."""
    return pb.Question(
        version=SCHEMA_VERSION,
        t_ns=question.t_ns,
        instruction_index=question.instruction_index,
        text=question.text,
        words=question.words,
        object_id=question.object_id,
    ).SerializeToString()


def decode_question(payload: bytes) -> Question:
    """Read a message of `question`."""
    message = parse(pb.Question(), payload, stream=Stream.QUESTION)
    return Question(
        t_ns=message.t_ns,
        instruction_index=message.instruction_index,
        text=message.text,
        words=tuple(message.words),
        object_id=message.object_id if message.HasField("object_id") else None,
    )


def _text(document: Document) -> str:
    # NaN is no JSON: what is unknown is null, and a number that is neither is a bug of the caller.
    return json.dumps(document, allow_nan=False)


def document_of(text: str, *, stream: str) -> Document:
    """Return the JSON object of a text, or raise InputError."""
    try:
        content = json.loads(text)
    except json.JSONDecodeError as error:
        raise _no_object(stream) from error
    if not isinstance(content, dict):
        raise _no_object(stream)
    return content


def _no_object(stream: str) -> InputError:
    return InputError("the text is no JSON object", where=stream, todo="correct the publisher")
