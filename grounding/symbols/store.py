"""Models on disk: read, written whole or not at all, and every version kept for a while.

Beside MODEL.json stands the folder `MODEL.json.versions` with what was there before, numbered
upwards. A version is put there before the file is replaced, both in one step each, so a kill at
any moment leaves a whole model.
"""

import os
import tempfile
from pathlib import Path
from typing import Final

from grounding.errors import InputError
from grounding.symbols.document import from_json, to_json
from grounding.symbols.model import SymbolModel

MAX_VERSIONS: Final = 50


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


def save_model(path: Path, model: SymbolModel) -> None:
    """Write a model; the one that was there becomes the latest version to go back to.

    Raises:
        InputError: if the folder cannot be written to.
    """
    try:
        _keep_version(path)
    except OSError as error:
        raise _unwritable(path, error) from error
    write_whole(path, to_json(model))


def undo(path: Path) -> SymbolModel:
    """Go back to the model that was there before, and return it.

    Raises:
        InputError: if there is none to go back to.
    """
    versions = _versions(path)
    if not versions:
        raise InputError("nothing to undo", where=path, todo="teach or forget a word first")
    earlier = read_model(versions[-1])
    try:
        versions[-1].replace(path)
    except OSError as error:
        raise _unwritable(path, error) from error
    return earlier


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
        raise _unwritable(path, error) from error


def _keep_version(path: Path) -> None:
    """Put the file as it is beside the versions, by a link that costs nothing."""
    if not path.exists():
        return
    versions = _versions(path)
    if versions and versions[-1].samefile(path):
        return  # a kill came between the two steps of an earlier save
    number = 1 + int(versions[-1].stem) if versions else 1
    folder = _folder(path)
    folder.mkdir(exist_ok=True)
    (folder / f"{number:06d}.json").hardlink_to(path)
    for old in versions[: max(0, len(versions) + 1 - MAX_VERSIONS)]:
        old.unlink()


def _versions(path: Path) -> list[Path]:
    return sorted(each for each in _folder(path).glob("*.json") if each.stem.isdigit())


def _folder(path: Path) -> Path:
    return path.with_name(f"{path.name}.versions")


def _unwritable(path: Path, error: OSError) -> InputError:
    return InputError(f"cannot be written ({error})", where=path, todo="choose another place")
