"""Configuration: a strict loader of TOML into frozen records.

Each stage keeps its own frozen dataclass with defaults beside the fields; a file names only what
differs. An unknown key, a wrong type or a broken file is an error that names the key's path.
"""

import dataclasses
import math
import tomllib
import types
import typing
from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Any, TypeVar

from gazemap.errors import ConfigError

T = TypeVar("T")


def load_config(record: type[T], path: Path) -> T:
    """Return the record with the values of a TOML file over its defaults.

    Raises:
        ConfigError: if the file cannot be read, or a key is unknown or of the wrong type.
    """
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror}); check --config") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: no valid TOML ({error}); correct it") from error
    return build_record(record, document, where=str(path))


def build_record(record: type[T], values: Mapping[str, Any], *, where: str) -> T:
    """Return the record with the given values over its defaults.

    Raises:
        ConfigError: if a key is unknown, missing or of the wrong type.
    """
    hints = typing.get_type_hints(record)
    fields = {f.name: f for f in dataclasses.fields(typing.cast("Any", record))}
    unknown = sorted(set(values) - set(fields))
    if unknown:
        known = ", ".join(sorted(fields))
        raise ConfigError(f"{where}: unknown key {unknown[0]!r}; known are: {known}")
    given = {
        name: _value(hints[name], value, where=f"{where}: {name}") for name, value in values.items()
    }
    try:
        return record(**given)
    except (TypeError, ValueError) as error:
        raise ConfigError(f"{where}: {error}") from error


def _value(hint: Any, value: Any, *, where: str) -> Any:  # noqa: ANN401  any field's type
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        if not isinstance(value, Mapping):
            raise ConfigError(f"{where}: a table expected, got {value!r}")
        return build_record(hint, value, where=where)
    if isinstance(hint, types.UnionType):
        return _first_fitting(typing.get_args(hint), value, where=where)
    if typing.get_origin(hint) is Mapping:
        if not isinstance(value, Mapping):
            raise ConfigError(f"{where}: a table expected, got {value!r}")
        item = typing.get_args(hint)[1]
        return {key: _value(item, each, where=f"{where}.{key}") for key, each in value.items()}
    if typing.get_origin(hint) is tuple:
        item = typing.get_args(hint)[0]
        return tuple(_value(item, each, where=where) for each in value)
    return _scalar(hint, value, where=where)


def _first_fitting(hints: tuple[Any, ...], value: Any, *, where: str) -> Any:  # noqa: ANN401
    for hint in hints:
        if hint is types.NoneType:
            continue
        return _value(hint, value, where=where)
    raise ConfigError(f"{where}: no type fits {value!r}")


def _scalar(hint: Any, value: Any, *, where: str) -> Any:  # noqa: ANN401
    if hint is Path and isinstance(value, str):
        return Path(value)
    if isinstance(hint, type) and issubclass(hint, StrEnum):
        if value in [each.value for each in hint]:
            return hint(value)
        raise ConfigError(f"{where}: one of {[e.value for e in hint]} expected, got {value!r}")
    if hint is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if isinstance(value, float) and math.isnan(value):
        raise ConfigError(f"{where}: a number expected, got {value}")
    if not isinstance(hint, type) or type(value) is not hint:
        raise ConfigError(f"{where}: {getattr(hint, '__name__', hint)} expected, got {value!r}")
    return value
