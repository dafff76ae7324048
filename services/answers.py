"""Answers to queries: the same documents as the commands print."""

import csv
import io
import math
from collections.abc import Sequence

import cv2
import numpy as np

from gazemap.errors import InputError
from gazemap.wire.streams import Stream
from grounding.features.registry import PatchFeatures, extract_features
from grounding.language.config import BackendChoice, LanguageConfig
from grounding.language.document import result_document
from grounding.language.parser import Parser, parser_for
from grounding.plan import GroundedInstruction, GroundedPlan
from grounding.query import PresentScene, ground_sentence
from grounding.symbols.classify import Classifier
from grounding.symbols.model import SymbolModel
from grounding.types import ImageArray, SpokenInstruction
from services.wire.grounding import Document
from services.wire.queries import (
    NamedPatch,
    ParseAnswer,
    decode_classify_request,
    decode_parse_request,
    encode_classify_answer,
    encode_parse_answer,
)

_CLASSIFY_COLUMNS = ("image", "group", "symbol", "score", "known")


def answer_parse(asked: bytes, parser: Parser) -> bytes:
    """Answer `parse`: one document for each sentence, each a discourse of its own."""
    request = decode_parse_request(asked)
    chosen = _parser_of(request.backend) if request.backend else parser
    documents = tuple(result_document(chosen.parse(sentence)) for sentence in request.sentences)
    return encode_parse_answer(ParseAnswer(plans=documents))


def _parser_of(backend: str) -> Parser:
    if backend not in list(BackendChoice):
        known = ", ".join(BackendChoice)
        raise InputError(f"no backend {backend!r}", where=Stream.PARSE, todo=f"use one of {known}")
    return parser_for(LanguageConfig(backend=BackendChoice(backend)))


def answer_classify(asked: bytes, model: SymbolModel) -> bytes:
    """Answer `classify`: the rows that `gazemap symbols classify` writes."""
    classifier = Classifier(model)
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(_CLASSIFY_COLUMNS)
    for patch in decode_classify_request(asked):
        if patch.mm_per_px is not None and not 0 < patch.mm_per_px < math.inf:
            what = f"{patch.name!r}: a positive mm_per_px expected, got {patch.mm_per_px}"
            raise InputError(what, where=Stream.CLASSIFY, todo="leave it out if it is not known")
        features = extract_features(_image_of(patch), mm_per_px=patch.mm_per_px)
        if not isinstance(features, PatchFeatures):
            writer.writerows((patch.name, group.name, "", "", 0) for group in model.groups)
            continue
        writer.writerows(
            (patch.name, each.group, each.symbol, f"{each.score:.6g}", int(each.known))
            for each in classifier.classify(features)
        )
    return encode_classify_answer(buffer.getvalue())


def _image_of(patch: NamedPatch) -> ImageArray:
    coded = np.frombuffer(patch.image, dtype=np.uint8)
    image = cv2.imdecode(coded, cv2.IMREAD_COLOR) if coded.size else None
    if image is None:
        raise InputError(
            f"{patch.name!r} is no image", where=Stream.CLASSIFY, todo="send a PNG or JPEG"
        )
    return np.asarray(image, dtype=np.uint8)


def ground_now(
    sentences: Sequence[str], parser: Parser, scene: PresentScene, *, session: str, scale: str
) -> Document:
    """Return a plan of sentences as they mean something in the present scene."""
    grounded: list[GroundedInstruction] = []
    for parse in parser.parse_discourse(sentences):
        for instruction in parse.instructions:
            spoken = SpokenInstruction(
                index=len(grounded),
                sentence=parse.sentence,
                instruction=instruction,
                said_start_ns=None,
                said_end_ns=None,
            )
            grounded.append(ground_sentence(spoken, scene))
    plan = GroundedPlan(session=session, revision=1, scale=scale, instructions=tuple(grounded))
    return plan.to_json()
