"""Writes a recording as one MCAP file, with the bytes that the bus carries."""

from pathlib import Path
from typing import Final

from google.protobuf.descriptor import Descriptor
from mcap.writer import Writer

from gazemap.ports import Progress
from gazemap.session.atomic import whole_file
from gazemap.session.recorded import RecordedSession
from gazemap.session.records import Record, records
from gazemap.wire.schemas import schema_data
from gazemap.wire.streams import Stream

CHUNK_BYTES: Final = 1024 * 1024
PROFILE: Final = "gazemap"
_ENCODING: Final = "protobuf"


def write_mcap(
    session: RecordedSession,
    path: Path,
    *,
    chunk_bytes: int = CHUNK_BYTES,
    progress: Progress | None = None,
) -> None:
    """Write a recording; the file is there whole or not at all.

    A video's packets are written as they are, in the order of decoding.

    Args:
        session: what to write.
        path: the file.
        chunk_bytes: how much is at stake if the file is cut off later.
        progress: told how many scene frames were written.
    """
    done, total = 0, len(session.scene_t_ns)
    with whole_file(path) as partial, partial.open("wb") as file:
        writer = McapWriter(Writer(file, chunk_size=chunk_bytes))
        for record in records(session):
            writer.write(record)
            if record.stream is Stream.HEAD_IMAGE and progress is not None:
                done += 1
                progress("writing", done, total)
        writer.finish()


class McapWriter:
    """Writes records to the channels of their streams."""

    def __init__(self, writer: Writer) -> None:
        """Start the file."""
        self._writer = writer
        self._channels: dict[tuple[Stream, str], int] = {}
        self._writer.start(profile=PROFILE, library="gazemap")

    def write(self, record: Record) -> None:
        """Add one message."""
        known = (record.stream, record.schema.full_name)
        if known not in self._channels:
            self._channels[known] = self._register(record.stream, record.schema)
        self._writer.add_message(
            channel_id=self._channels[known],
            log_time=record.log_ns,
            publish_time=record.log_ns,
            data=record.payload,
        )

    def _register(self, stream: Stream, schema: Descriptor) -> int:
        number = self._writer.register_schema(schema.full_name, _ENCODING, schema_data(schema))
        return self._writer.register_channel(stream.value, _ENCODING, number)

    def finish(self) -> None:
        """Write what is left, and the index."""
        self._writer.finish()  # type: ignore[no-untyped-call]
