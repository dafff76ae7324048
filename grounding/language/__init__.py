"""From a sentence through EDS to abstract instructions; the home of PyDelphin."""

from grounding.language.parser import Parser, ParseResult, default_parser

__all__ = ["ParseResult", "Parser", "default_parser"]
