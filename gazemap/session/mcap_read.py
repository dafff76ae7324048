"""The native recording: one MCAP file, read as far as it is whole."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from mcap.exceptions import McapError
from mcap.records import Channel, Message, Schema
from mcap.stream_reader import CRCValidationError, StreamReader
from zstandard import ZstdError

from gazemap.errors import InputError
from gazemap.wire.streams import Stream

# A damaged length may ask for more than there is memory.
_DAMAGE = (
    McapError,
    CRCValidationError,
    ZstdError,
    struct.error,
    UnicodeDecodeError,
    OverflowError,
    MemoryError,
)
_STREAMS = {stream.value: stream for stream in Stream}


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredMessage:
    """A message as it lies in the file."""

    stream: Stream
    schema_name: str
    payload: bytes


@dataclass(slots=True)
class McapFile:
    """A file that is read from its start, chunk by chunk.

    Attributes:
        path: the file.
        is_cut: whether the last reading ended before the file's end mark.
    """

    path: Path
    is_cut: bool = False

    def messages(self, *streams: Stream) -> Iterator[StoredMessage]:
        """Yield the messages of some streams, or of all, up to the last whole chunk.

        Raises:
            InputError: if it is no MCAP file.
        """
        schemas: dict[int, str] = {}
        channels: dict[int, tuple[Stream, str]] = {}
        for record in self._records():
            if isinstance(record, Schema):
                schemas[record.id] = record.name
            elif isinstance(record, Channel) and record.topic in _STREAMS:
                channels[record.id] = (_STREAMS[record.topic], schemas.get(record.schema_id, ""))
            elif isinstance(record, Message) and record.channel_id in channels:
                stream, name = channels[record.channel_id]
                if not streams or stream in streams:
                    yield StoredMessage(stream=stream, schema_name=name, payload=record.data)

    def _records(self) -> Iterator[object]:
        self.is_cut = False
        seen = 0
        try:
            with self.path.open("rb") as file:
                for record in StreamReader(file, validate_crcs=True).records:
                    seen += 1
                    yield record
        except OSError as error:
            raise InputError(
                f"cannot be read ({error.strerror})", where=self.path, todo="copy it again"
            ) from error
        except _DAMAGE as error:
            self.is_cut = True
            if seen == 0:
                raise InputError(
                    "no MCAP file", where=self.path, todo="give a recording"
                ) from error
