"""JSON and YAML files that hold one mapping."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from gazemap.errors import InputError
from gazemap.geometry.arrays import FloatArray

Document = dict[str, Any]


def read_json(path: Path) -> Document:
    """Return the object of a JSON file."""
    try:
        content = json.loads(_text(path))
    except (json.JSONDecodeError, RecursionError) as error:
        raise InputError(f"no JSON ({error})", where=path, todo="correct the file") from error
    return _mapping(content, path)


def read_yaml(path: Path) -> Document:
    """Return the mapping of a YAML file; OpenCV's `%YAML:1.0` line is allowed."""
    text = _text(path)
    if text.startswith("%YAML:"):
        text = text.partition("\n")[2]
    try:
        content = yaml.safe_load(text)
    except (yaml.YAMLError, RecursionError) as error:
        raise InputError(_yaml_problem(error), where=path, todo="correct the file") from error
    return _mapping(content, path)


def _yaml_problem(error: Exception) -> str:
    """Return in one line what PyYAML says in several."""
    if isinstance(error, yaml.MarkedYAMLError) and error.problem_mark is not None:
        return f"no YAML (line {error.problem_mark.line + 1}: {error.problem})"
    return "no YAML (" + " ".join(str(error).split()) + ")"


def numbers(document: Document, key: str, *, path: Path | str) -> FloatArray:
    """Return the numbers under a key, flat (N,), however they are nested."""
    try:
        values = np.asarray(document[key], dtype=np.float64).ravel()
    except KeyError as error:
        raise InputError(f"'{key}' is missing", where=path, todo="add it") from error
    except (TypeError, ValueError) as error:
        raise InputError(f"'{key}' must be numbers", where=path, todo="correct it") from error
    if not np.isfinite(values).all():
        raise InputError(f"'{key}' must be finite numbers", where=path, todo="correct it")
    return values


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError as error:
        raise InputError("the file is missing", where=path, todo="add it") from error
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot be read ({error})", where=path, todo="copy it again") from error


def _mapping(content: object, path: Path) -> Document:
    if not isinstance(content, dict):
        raise InputError(
            f"a mapping expected, got {type(content).__name__}", where=path, todo="correct the file"
        )
    return content
