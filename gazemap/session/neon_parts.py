"""The raw parts of a Neon phone's recording.

Each stream is in parts, `NAME psN.raw` with `NAME psN.time` (int64 nanoseconds) beside it; newer
versions name the fields in `NAME.dtype`.
"""

import ast
import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from google.protobuf.message import DecodeError
from numpy.typing import NDArray

from gazemap.errors import InputError
from gazemap.geometry.arrays import BoolArray, IntArray
from gazemap.wire.generated.neon_imu_pb2 import ImuPacket

_PART: Final = re.compile(r" ps(\d+)$")


@dataclass(frozen=True, slots=True, kw_only=True)
class RawPart:
    """One part of a stream.

    Attributes:
        raw: the file of rows.
        fields: what a row is made of.
    """

    raw: Path
    fields: np.dtype[Any]

    def rows(self) -> NDArray[Any]:
        """Return the rows (N,)."""
        return _array(self.raw, self.fields)

    def t_ns(self) -> IntArray:
        """Return the rows' times (N,)."""
        t_ns = read_times(self.raw.with_suffix(".time"))
        if len(t_ns) != len(self.rows()):
            raise damaged(self.raw, f"{len(self.rows())} rows for {len(t_ns)} times")
        return t_ns


def part_files(folder: Path, name: str, *, suffix: str) -> list[Path]:
    """Return the files of a stream's parts in their order."""
    numbered = {
        int(match.group(1)): path
        for path in folder.glob(f"{name} ps*{suffix}")
        if (match := _PART.search(path.stem))
    }
    return [numbered[number] for number in sorted(numbered)]


def parts(folder: Path, name: str, *, fields: np.dtype[Any] | None = None) -> list[RawPart]:
    """Return a stream's parts; `fields` is what older versions do not name in a file."""
    files = part_files(folder, name, suffix=".raw")
    if not files:
        return []
    named = folder / f"{name}.dtype"
    if named.is_file():
        fields = _fields(named)
    if fields is None:
        raise damaged(named, "the file is missing")
    return [RawPart(raw=file, fields=fields) for file in files]


def read_times(path: Path) -> IntArray:
    """Return the times of a part (N,)."""
    return _array(path, np.dtype("<i8")).astype(np.int64)


def new_times(t_ns: IntArray, *, where: Path) -> BoolArray:
    """Return which rows to keep (N,): repeated times count once.

    Raises:
        InputError: if the times run backwards.
    """
    steps = np.diff(t_ns)
    if (steps < 0).any():
        raise damaged(where, "the times run backwards")
    return np.concatenate([np.ones(min(len(t_ns), 1), dtype=np.bool_), steps > 0])


def imu_packets(path: Path) -> Iterator[ImuPacket]:
    """Yield the packets of an older version's inertial stream; each is led by its 16-bit length."""
    content, start = path.read_bytes(), 0
    while start < len(content):
        try:
            (length,) = struct.unpack_from("<H", content, start)
            packet = ImuPacket()
            packet.ParseFromString(content[start + 2 : start + 2 + length])
        except (struct.error, DecodeError) as error:
            raise damaged(path, f"no packet at byte {start}") from error
        yield packet
        start += 2 + length


def damaged(path: Path, what: str) -> InputError:
    """Return the error of a part that cannot be used."""
    return InputError(what, where=path, todo="the recording is damaged: copy it again")


def _array(path: Path, fields: np.dtype[Any]) -> NDArray[Any]:
    try:
        content = path.read_bytes()
    except OSError as error:
        raise damaged(path, f"cannot be read ({error.strerror})") from error
    if len(content) % fields.itemsize:
        raise damaged(path, f"{len(content)} bytes are no whole rows of {fields.itemsize}")
    return np.frombuffer(content, dtype=fields)


def _fields(path: Path) -> np.dtype[Any]:
    try:
        names = ast.literal_eval(path.read_text().strip())
        fields: np.dtype[Any] = np.dtype(names).newbyteorder("<")
    except (OSError, SyntaxError, ValueError, TypeError) as error:
        raise damaged(path, "no list of fields") from error
    return fields
