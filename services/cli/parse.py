"""`gazemap parse`: sentences in, one JSON object each out."""

import json
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from grounding.errors import InputError
    from grounding.language.config import LanguageConfig
    from grounding.language.parser import Parser, ParseResult

_BACKENDS = ["auto", "ace", "rest", "embedded", "eds"]


@click.command()
@click.argument("sentences", nargs=-1, metavar="[SENTENCE...]")
@click.option("--backend", type=click.Choice(_BACKENDS), help="Default: ace where installed.")
@click.option("--config", type=click.Path(path_type=Path), help="TOML; see docs/language.md.")
@click.option("--server", help="Address of a DELPH-IN web service, for the backend rest.")
@click.option("--verb", "verbs", multiple=True, metavar="NEW=LIKE", help="Teach a verb.")
def command(
    sentences: tuple[str, ...], *, backend: str | None, config: Path | None, server: str | None,
    verbs: tuple[str, ...],
) -> None:  # fmt: skip
    """Print what each SENTENCE, or each line of the standard input, says to do."""
    from grounding.language.document import result_document
    from grounding.language.parser import parser_for

    settings = _settings(config, backend=backend, server=server, verbs=verbs)
    parser = parser_for(settings)
    lines = map(_unicode, sentences) if sentences else _lines()
    unread: list[InputError] = []
    results = _recorded(lines, parser, unread) if backend == "eds" else map(parser.parse, lines)
    for result in results:
        print(json.dumps(result_document(result)), flush=True)
    if unread:
        raise unread[0]


def _settings(
    config: Path | None, *, backend: str | None, server: str | None, verbs: tuple[str, ...]
) -> "LanguageConfig":
    from gazemap.config import load_config
    from grounding.language.config import BackendChoice, LanguageConfig

    settings = LanguageConfig() if config is None else load_config(LanguageConfig, config)
    if backend is not None:
        chosen = "embedded" if backend == "eds" else backend
        settings = replace(settings, backend=BackendChoice(chosen))
    if server is not None:
        settings = replace(settings, server=server)
    taught = dict(_pair(each) for each in verbs)
    return replace(settings, verbs={**settings.verbs, **taught})


def _pair(text: str) -> tuple[str, str]:
    new, separator, like = text.partition("=")
    if not separator:
        raise click.BadParameter(f"{text!r}: NEW=LIKE expected, for example ponder=look")
    return new, like


def _lines() -> Iterator[str]:
    """Yield the lines of the standard input; bytes that are no UTF-8 are replaced."""
    if sys.stdin is None:
        raise click.UsageError("the standard input is closed; give the sentences as arguments")
    for line in sys.stdin.buffer:
        yield line.decode("utf-8", errors="replace").rstrip("\r\n")


def _unicode(argument: str) -> str:
    """Return an argument of the shell; bytes that are no UTF-8 are replaced, as in a line."""
    return argument.encode("utf-8", errors="surrogateescape").decode("utf-8", errors="replace")


def _recorded(
    lines: Iterator[str], parser: "Parser", unread: "list[InputError]"
) -> Iterator["ParseResult"]:
    """Yield what recorded readings say, one JSON object a line; collect why one is unread."""
    from grounding.errors import InputError
    from grounding.language.parser import ParseResult
    from grounding.language.recorded import recorded_reading

    for number, line in enumerate(lines, start=1):
        try:
            recorded = recorded_reading(line, where=f"line {number}")
        except InputError as error:
            unread.append(error)
            yield ParseResult(sentence=line, backend="eds", error=str(error), instructions=())
            continue
        if recorded is None:
            yield parser.parse_reading(line, None)
        else:
            yield parser.parse_reading(recorded.sentence, recorded.eds)
