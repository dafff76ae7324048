"""The csv files that name patches: LABELS.csv to learn from, a list to classify."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

from grounding.errors import InputError


@dataclass(frozen=True, slots=True, kw_only=True)
class ListedPatch:
    """One row: an image and what is known of it.

    Attributes:
        name: the image as the file gives it.
        path: where it is.
        mm_per_px: metric scale, or None.
        symbols: the words said of it; empty in a list to classify.
        segment: names the labelling decision; each row is its own where none is given.
        weight: the posterior that the label is right.
    """

    name: str
    path: Path
    mm_per_px: float | None = None
    symbols: tuple[str, ...] = ()
    segment: str = ""
    weight: float = 1.0


def read_labels(path: Path) -> list[ListedPatch]:
    """Read `image,symbols[,segment][,mm_per_px][,weight]`.

    Raises:
        InputError: if the file, a column or a number in it cannot be used.
    """
    return [
        ListedPatch(
            name=row["image"],
            path=path.parent / row["image"],
            mm_per_px=_number(row, "mm_per_px", path, line),
            symbols=tuple(row["symbols"].lower().split()),
            segment=row.get("segment") or f"row {line}",
            weight=_weight(row, path, line),
        )
        for line, row in _rows(path, ("image", "symbols"))
    ]


def read_list(path: Path) -> list[ListedPatch]:
    """Read `image[,mm_per_px]`.

    Raises:
        InputError: if the file, a column or a number in it cannot be used.
    """
    return [
        ListedPatch(
            name=row["image"],
            path=path.parent / row["image"],
            mm_per_px=_number(row, "mm_per_px", path, line),
        )
        for line, row in _rows(path, ("image",))
    ]


def _rows(path: Path, wanted: tuple[str, ...]) -> list[tuple[int, dict[str, str]]]:
    """Return the rows with their line numbers; further columns are ignored."""
    todo = f"give a csv file with the columns {', '.join(wanted)}"
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file, restval="")
            missing = [name for name in wanted if name not in (reader.fieldnames or ())]
            if missing:
                raise InputError(f"no column {missing[0]!r}", where=path, todo=todo)
            return [(reader.line_num, row) for row in reader if row["image"]]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"cannot be read ({error})", where=path, todo=todo) from error


def _weight(row: dict[str, str], path: Path, line: int) -> float:
    """Return the weight in [0, 1]; 1 for an empty field."""
    weight = _number(row, "weight", path, line, zero_allowed=True)
    return 1.0 if weight is None else min(1.0, weight)


def _number(
    row: dict[str, str], name: str, path: Path, line: int, *, zero_allowed: bool = False
) -> float | None:
    """Return a positive number, or None for an empty field."""
    text = (row.get(name) or "").strip()
    if not text:
        return None
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number) or number < 0 or (number == 0 and not zero_allowed):
        raise InputError(
            f"{name} is {text!r}, expected a positive number",
            where=f"{path}, line {line}",
            todo="correct it or leave the field empty",
        )
    return number
