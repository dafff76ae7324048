"""Models on disk."""

import os
import tempfile
from pathlib import Path

from grounding.errors import InputError
from grounding.symbols.document import from_json
from grounding.symbols.model import SymbolModel


def read_model(path: Path) -> SymbolModel:
    """Read a model.

    Raises:
        InputError: if there is none, or it cannot be used.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"cannot be read ({error})",
            where=path,
            todo="fit a model first: gazemap symbols fit LABELS.csv --out MODEL.json",
        ) from error
    return from_json(text, where=str(path))


def write_whole(path: Path, text: str) -> None:
    """Write a file whole or not at all, also when the power fails.

    Raises:
        InputError: if the folder cannot be written to.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        Path(name).chmod(0o644)
        Path(name).replace(path)
    except OSError as error:
        raise InputError(
            f"cannot be written ({error})", where=path, todo="choose another place"
        ) from error
