"""Answers to queries: the same documents as the commands print."""

from grounding.language.document import result_document
from grounding.language.parser import Parser
from services.wire.queries import ParseAnswer, decode_parse_request, encode_parse_answer


def answer_parse(asked: bytes, parser: Parser) -> bytes:
    """Answer `parse`: one document for each sentence, each a discourse of its own."""
    sentences = decode_parse_request(asked).sentences
    documents = tuple(result_document(parser.parse(sentence)) for sentence in sentences)
    return encode_parse_answer(ParseAnswer(plans=documents))
