"""Csv files, read strictly: a wrong field is an error that names its line."""

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import numpy as np

from gazemap.errors import InputError
from gazemap.geometry.arrays import BoolArray, FloatArray, IntArray

_SHOWN_CHARACTERS = 160
_TRUE, _FALSE = frozenset({"1", "1.0", "true"}), frozenset({"0", "0.0", "false"})


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """The columns of a csv file as texts; columns that nobody asks for are ignored.

    Attributes:
        path: the file.
        columns: name to fields.
        lines: the line of the file that each row ends on, from 1.
    """

    path: Path
    columns: dict[str, list[str]]
    lines: list[int]

    def __len__(self) -> int:
        return len(self.lines)

    def has(self, name: str) -> bool:
        """Tell whether the file has the column."""
        return name in self.columns

    def texts(self, name: str) -> list[str]:
        """Return a column's fields."""
        if name not in self.columns:
            raise InputError(
                f"no column '{name}'; found: {_shown(', '.join(self.columns))}",
                where=self.path,
                todo="name the columns as the format asks",
            )
        return self.columns[name]

    def ints(self, name: str) -> IntArray:
        """Return a column of integers (N,), which are written without exponent."""
        fields = self.texts(name)
        values = np.empty(len(fields), dtype=np.int64)
        for i, text in enumerate(fields):
            try:
                values[i] = int(text)
            except (ValueError, OverflowError) as error:
                raise self.wrong_field(i, name=name, wanted="an integer") from error
        return values

    def floats(self, name: str) -> FloatArray:
        """Return a column of numbers (N,); an empty field is unknown and becomes NaN.

        The text `nan` is no number: an unknown number is an empty field.
        """
        fields = self.texts(name)
        values = np.full(len(fields), np.nan)
        for i, text in enumerate(fields):
            if not text:
                continue
            try:
                values[i] = float(text)
            except ValueError as error:
                raise self.wrong_field(i, name=name, wanted="a number") from error
            if not np.isfinite(values[i]):
                raise self.wrong_field(i, name=name, wanted="a finite number or an empty field")
        return values

    def flags(self, name: str) -> BoolArray:
        """Return a column of booleans (N,), written 1 and 0; an empty field is false."""
        values = np.zeros(len(self), dtype=np.bool_)
        for i, text in enumerate(self.texts(name)):
            if text.lower() in _TRUE:
                values[i] = True
            elif text and text.lower() not in _FALSE:
                raise self.wrong_field(i, name=name, wanted="1 or 0")
        return values

    def wrong_field(self, row: int, *, name: str, wanted: str) -> InputError:
        """Return the error that names a field that cannot be used."""
        return InputError(
            f"column '{name}': {wanted} expected, got '{_shown(self.columns[name][row])}'",
            where=f"{self.path}, line {self.lines[row]}",
            todo="correct the line or export the file again",
        )


def read_table(path: Path) -> Table:
    """Read a csv file with a header; blank lines are skipped.

    Raises:
        InputError: if the file cannot be read or a row has fewer fields than the header.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            return _parse(file, path)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(
            f"cannot be read as csv ({error})", where=path, todo="export the file again"
        ) from error


def _parse(file: TextIO, path: Path) -> Table:
    rows = csv.reader(file)
    names = [name.strip().lstrip("#").strip() for name in next(rows, [])]
    if not any(names):
        raise InputError("the file is empty", where=path, todo="export the file again")
    fields: list[list[str]] = []
    lines: list[int] = []
    for row in rows:
        if not any(row):
            continue
        if len(row) < len(names):
            raise InputError(
                f"{len(names)} fields expected, got {len(row)}",
                where=f"{path}, line {rows.line_num}",
                todo="the file may be cut off: export or copy it again",
            )
        # Ids repeat from row to row: one string for all halves the memory that an hour takes.
        above = fields[-1] if fields else row
        fields.append([up if text == up else text for text, up in zip(row, above, strict=False)])
        lines.append(rows.line_num)
    columns = {name: [row[i].strip() for row in fields] for i, name in enumerate(names)}
    return Table(path=path, columns=columns, lines=lines)


def _shown(text: str) -> str:
    """Return a field so that it fits into a line, also where a stray quote swallowed lines."""
    line = " ".join(text.split())
    return line if len(line) <= _SHOWN_CHARACTERS else line[:_SHOWN_CHARACTERS] + "..."


def times_ns(table: Table, name: str) -> tuple[IntArray, BoolArray]:
    """Return a column of times (N,) and which rows to keep (N,): repeated times count once.

    Raises:
        InputError: if a time is before the one of the row above.
    """
    t_ns = table.ints(name)
    if (t_ns < 0).any():
        raise table.wrong_field(
            int(np.flatnonzero(t_ns < 0)[0]), name=name, wanted="nanoseconds since 1970"
        )
    steps = np.diff(t_ns)
    if (steps < 0).any():
        row = int(np.flatnonzero(steps < 0)[0]) + 1
        raise InputError(
            f"column '{name}': {t_ns[row]} is before the row above, {t_ns[row - 1]}",
            where=f"{table.path}, line {table.lines[row]}",
            todo="sort the rows by time, or export the file again",
        )
    return t_ns, np.concatenate([np.ones(min(len(t_ns), 1), dtype=np.bool_), steps > 0])
