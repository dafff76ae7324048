"""From a sentence through EDS to abstract instructions; the home of PyDelphin."""

from grounding.language.parser import (
    Parser,
    ParseResult,
    SentenceParse,
    default_parser,
    parser_for,
)

__all__ = ["ParseResult", "Parser", "SentenceParse", "default_parser", "parser_for"]
