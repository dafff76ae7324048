"""WebVTT narration; the text is kept as it was said, without its markup."""

import html
import itertools
import re
from collections.abc import Iterator
from pathlib import Path

from gazemap.errors import InputError
from gazemap.types.session import Cue

_TIME = r"(?:(\d{2,}):)?([0-5]\d):([0-5]\d)\.(\d{3})"
_TIMING = re.compile(rf"^{_TIME}[ \t]+-->[ \t]+{_TIME}(?:[ \t].*)?$")
_MARKUP = re.compile(r"<[^>]*>")
_NO_CUES = ("NOTE", "STYLE", "REGION")
Block = list[tuple[int, str]]


def read_narration(path: Path, *, zero_ns: int) -> tuple[Cue, ...]:
    """Read narration.vtt.

    Args:
        path: the file.
        zero_ns: when its clock starts: the first scene frame.

    Raises:
        InputError: if it is no WebVTT, a cue's times are wrong, or it holds no sentence.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot be read ({error})", where=path, todo="copy it again") from error
    if not lines or not re.match(r"WEBVTT(\s|$)", lines[0]):
        what = "the narration is empty" if not any(lines) else "the first line is not WEBVTT"
        raise InputError(what, where=path, todo="write WebVTT, or remove the file")
    cues = [cue for block in _blocks(lines) if (cue := _cue(block, path, zero_ns)) is not None]
    if not cues:
        raise InputError(
            "the narration is empty: no cue with words in it",
            where=path,
            todo="add what was said, or remove the file",
        )
    _check_order(cues, path)
    return tuple(cues)


def _blocks(lines: list[str]) -> Iterator[Block]:
    """Yield the groups of numbered lines between blank lines, after the header."""
    block: Block = []
    for number, line in enumerate([*lines[1:], ""], start=2):
        if line.strip():
            block.append((number, line))
        elif block:
            yield block
            block = []


def _cue(block: Block, path: Path, zero_ns: int) -> Cue | None:
    if block[0][1].split()[0] in _NO_CUES or not any("-->" in line for _, line in block):
        return None
    timing = 0 if "-->" in block[0][1] else 1
    number, line = block[min(timing, len(block) - 1)]
    match = _TIMING.match(line.strip())
    if match is None:
        raise _wrong(path, number, f"'00:00:01.000 --> 00:00:02.000' expected, got '{line}'")
    start_ns, end_ns = _time_ns(*match.groups()[:4]), _time_ns(*match.groups()[4:])
    if end_ns <= start_ns:
        raise _wrong(path, number, "the cue ends before it starts")
    words = " ".join(text.strip() for _, text in block[timing + 1 :])
    text = " ".join(html.unescape(_MARKUP.sub("", words)).split())
    return Cue(start_ns=zero_ns + start_ns, end_ns=zero_ns + end_ns, text=text) if text else None


def _time_ns(hours: str | None, minutes: str, seconds: str, milliseconds: str) -> int:
    whole_s = (int(hours or 0) * 60 + int(minutes)) * 60 + int(seconds)
    return (whole_s * 1000 + int(milliseconds)) * 1_000_000


def _check_order(cues: list[Cue], path: Path) -> None:
    for before, after in itertools.pairwise(cues):
        if after.start_ns < before.start_ns:
            raise InputError(
                f"the cue '{after.text}' starts before the one above it",
                where=path,
                todo="sort the cues by time: the narration is one discourse",
            )


def _wrong(path: Path, number: int, what: str) -> InputError:
    return InputError(what, where=f"{path}, line {number}", todo="correct the cue")
