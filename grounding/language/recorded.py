"""Readings that were made elsewhere and written down as JSON."""

import json
from dataclasses import dataclass
from typing import Final

from delphin.codecs import eds as native
from delphin.eds import EDS
from delphin.exceptions import PyDelphinException

from grounding.errors import InputError

# PyDelphin's lexer ends a cut text with a bare StopIteration.
_UNREADABLE: Final = (
    PyDelphinException, ValueError, TypeError, KeyError, AttributeError, StopIteration,
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recorded:
    """A sentence with one reading."""

    sentence: str
    eds: EDS


def recorded_reading(line: str, *, where: str) -> Recorded | None:
    """Return the reading in a line of JSON, or None for a blank line.

    Raises:
        InputError: if the line holds something else.
    """
    if not line.strip():
        return None
    todo = 'write one object {"sentence": ..., "eds_native": ...} a line'
    try:
        row = json.loads(line)
        sentence, text = _field(row, "sentence"), _field(row, "eds_native")
        if not isinstance(sentence, str) or not isinstance(text, str):
            raise InputError("sentence and eds_native must be text", where=where, todo=todo)
        return Recorded(sentence=sentence, eds=native.decode(text))
    except RecursionError as error:
        raise InputError("nested too deeply", where=where, todo=todo) from error
    except _UNREADABLE as error:
        raise InputError(f"no recorded EDS ({error})", where=where, todo=todo) from error


def _field(row: object, name: str) -> object:
    if not isinstance(row, dict) or name not in row:
        raise ValueError(f"{name} is missing")
    return row[name]
