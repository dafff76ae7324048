"""What every message shares: the schema's version, and one way to refuse what cannot be read.

Our own messages carry `version` as their first field. A Foxglove message has none: ours are a
Foxglove message with an extra one of ours appended, which is one protobuf message to whoever knows
both (bytes that are joined are merged) and a plain Foxglove message to all others. A Foxglove
message without an extra is accepted.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Final, Protocol, TypeVar

from google.protobuf.message import DecodeError
from google.protobuf.timestamp_pb2 import Timestamp

from gazemap.errors import ConventionError, InputError
from gazemap.geometry.arrays import FloatArray, frozen_floats

SCHEMA_VERSION: Final = 1
_NS_PER_S: Final = 1_000_000_000


class _Parsed(Protocol):
    def ParseFromString(self, serialized: bytes) -> int:  # noqa: N802  protobuf's name
        """Fill the message."""


class _Versioned(_Parsed, Protocol):
    version: int


Versioned = TypeVar("Versioned", bound=_Versioned)


def parse(message: Versioned, payload: bytes, *, stream: str) -> Versioned:
    """Fill one of our messages.

    Raises:
        InputError: if the bytes are none, or of another version.
    """
    _fill(message, payload, stream=stream)
    if message.version != SCHEMA_VERSION:
        raise _other_version(message.version, stream)
    return message


def parse_foxglove(message: _Parsed, extra: _Versioned, payload: bytes, *, stream: str) -> None:
    """Fill a Foxglove message, and its extra of ours where it has one.

    Raises:
        InputError: if the bytes are none, or of another version.
    """
    _fill(message, payload, stream=stream)
    _fill(extra, payload, stream=stream)
    if extra.version not in (0, SCHEMA_VERSION):
        raise _other_version(extra.version, stream)


def _fill(message: _Parsed, payload: bytes, *, stream: str) -> None:
    try:
        message.ParseFromString(payload)
    except DecodeError as error:
        raise InputError(
            f"{len(payload)} bytes that are no message of this stream",
            where=stream,
            todo="publish protobuf of package gazemap.v1",
        ) from error


def _other_version(version: int, stream: str) -> InputError:
    return InputError(
        f"schema version {version} is unknown, {SCHEMA_VERSION} expected",
        where=stream,
        todo="use the same release of gazemap on both sides",
    )


@contextmanager
def refusing(stream: str) -> Iterator[None]:
    """Turn what a record does not accept into the error of a message that cannot be used."""
    try:
        yield
    except (ConventionError, ValueError) as error:
        raise InputError(
            f"a message that cannot be used ({error})", where=stream, todo="correct the publisher"
        ) from error


def vector(values: Sequence[float], length: int, *, name: str) -> FloatArray:
    """Return a repeated field as finite numbers (length,)."""
    return frozen_floats(values, (length,), name=name)


def matrix(values: Sequence[float], size: int, *, name: str) -> FloatArray:
    """Return a repeated field, row by row, as finite numbers (size, size)."""
    return vector(values, size * size, name=name).reshape(size, size)


def timestamp(t_ns: int) -> Timestamp:
    """Return a time as Foxglove's schemas write it."""
    return Timestamp(seconds=t_ns // _NS_PER_S, nanos=t_ns % _NS_PER_S)


def time_ns(stamp: Timestamp) -> int:
    """Return the nanoseconds of a Foxglove time."""
    return stamp.seconds * _NS_PER_S + stamp.nanos
