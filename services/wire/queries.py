"""Questions to the grounding service and its answers: `parse`, `ground`, `classify`, `teach`."""

import json
from dataclasses import dataclass

from gazemap.wire.envelope import SCHEMA_VERSION, parse
from gazemap.wire.generated import gazemap_grounding_pb2 as pb
from gazemap.wire.streams import Stream
from services.wire.grounding import Document, document_of


@dataclass(frozen=True, slots=True, kw_only=True)
class ParseRequest:
    """Sentences to parse, a discourse each; an empty backend is the service's own."""

    sentences: tuple[str, ...]
    backend: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ParseAnswer:
    """One object a sentence, as `gazemap parse` prints it."""

    plans: tuple[Document, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundRequest:
    """Sentences to ground beside those that were heard; none: ground again what was heard."""

    sentences: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class NamedPatch:
    """An image patch to classify.

    Attributes:
        name: echoed in the answer.
        image: PNG or JPEG.
        mm_per_px: its scale, or None.
    """

    name: str
    image: bytes
    mm_per_px: float | None = None


def encode_parse_request(request: ParseRequest) -> bytes:
    """Return the question of `parse`."""
    return pb.ParseRequest(
        version=SCHEMA_VERSION, sentences=request.sentences, backend=request.backend
    ).SerializeToString()


def decode_parse_request(payload: bytes) -> ParseRequest:
    """Read the question of `parse`."""
    message = parse(pb.ParseRequest(), payload, stream=Stream.PARSE)
    return ParseRequest(sentences=tuple(message.sentences), backend=message.backend)


def encode_parse_answer(answer: ParseAnswer) -> bytes:
    """Return the answer of `parse`."""
    texts = [json.dumps(plan, allow_nan=False) for plan in answer.plans]
    return pb.ParseAnswer(version=SCHEMA_VERSION, json=texts).SerializeToString()


def decode_parse_answer(payload: bytes) -> ParseAnswer:
    """Read the answer of `parse`."""
    message = parse(pb.ParseAnswer(), payload, stream=Stream.PARSE)
    return ParseAnswer(plans=tuple(document_of(text, stream=Stream.PARSE) for text in message.json))


def encode_ground_request(request: GroundRequest) -> bytes:
    """Return the question of `ground`."""
    return pb.GroundRequest(version=SCHEMA_VERSION, sentences=request.sentences).SerializeToString()


def decode_ground_request(payload: bytes) -> GroundRequest:
    """Read the question of `ground`."""
    message = parse(pb.GroundRequest(), payload, stream=Stream.GROUND)
    return GroundRequest(sentences=tuple(message.sentences))


def encode_ground_answer(plan: Document) -> bytes:
    """Return the answer of `ground`: a plan as plan.json has it."""
    return pb.GroundAnswer(
        version=SCHEMA_VERSION, json=json.dumps(plan, allow_nan=False)
    ).SerializeToString()


def decode_ground_answer(payload: bytes) -> Document:
    """Read the answer of `ground`."""
    message = parse(pb.GroundAnswer(), payload, stream=Stream.GROUND)
    return document_of(message.json, stream=Stream.GROUND)


def encode_classify_request(patches: tuple[NamedPatch, ...]) -> bytes:
    """Return the question of `classify`."""
    sent = [
        pb.ClassifyRequest.Patch(name=each.name, image=each.image, mm_per_px=each.mm_per_px)
        for each in patches
    ]
    return pb.ClassifyRequest(version=SCHEMA_VERSION, patches=sent).SerializeToString()


def decode_classify_request(payload: bytes) -> tuple[NamedPatch, ...]:
    """Read the question of `classify`."""
    message = parse(pb.ClassifyRequest(), payload, stream=Stream.CLASSIFY)
    return tuple(
        NamedPatch(
            name=each.name,
            image=each.image,
            mm_per_px=each.mm_per_px if each.HasField("mm_per_px") else None,
        )
        for each in message.patches
    )


def encode_classify_answer(csv_text: str) -> bytes:
    """Return the answer of `classify`: csv rows image,group,symbol,score,known with a header."""
    return pb.ClassifyAnswer(version=SCHEMA_VERSION, csv=csv_text).SerializeToString()


def decode_classify_answer(payload: bytes) -> str:
    """Read the answer of `classify`."""
    return parse(pb.ClassifyAnswer(), payload, stream=Stream.CLASSIFY).csv


def encode_teach_request(lesson: Document) -> bytes:
    """Return the question of `teach`: a word for a thing, or a verb for an action."""
    return pb.TeachRequest(
        version=SCHEMA_VERSION, json=json.dumps(lesson, allow_nan=False)
    ).SerializeToString()


def decode_teach_request(payload: bytes) -> Document:
    """Read the question of `teach`."""
    message = parse(pb.TeachRequest(), payload, stream=Stream.TEACH)
    return document_of(message.json, stream=Stream.TEACH)


def encode_teach_answer(outcome: Document) -> bytes:
    """Return the answer of `teach`."""
    return pb.TeachAnswer(
        version=SCHEMA_VERSION, json=json.dumps(outcome, allow_nan=False)
    ).SerializeToString()


def decode_teach_answer(payload: bytes) -> Document:
    """Read the answer of `teach`."""
    message = parse(pb.TeachAnswer(), payload, stream=Stream.TEACH)
    return document_of(message.json, stream=Stream.TEACH)
