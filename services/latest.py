"""Streams whose latest message can also be asked for."""

from collections.abc import Callable

from gazemap.errors import InputError
from gazemap.wire.streams import Stream
from services.bus.base import Bus


class LatestMessages:
    """The latest message of each stream that is also a queryable."""

    def __init__(self, bus: Bus, *streams: Stream) -> None:
        """Answer queries of these streams."""
        self._bus = bus
        self._payloads: dict[Stream, bytes] = {}
        for stream in streams:
            bus.answer(stream, self._answer(stream))

    def _answer(self, stream: Stream) -> Callable[[bytes], bytes]:
        def answer(_asked: bytes) -> bytes:
            if stream not in self._payloads:
                todo = "ask again once the session has led to one"
                raise InputError("no message yet", where=stream, todo=todo)
            return self._payloads[stream]

        return answer

    def publish(self, stream: Stream, payload: bytes) -> None:
        """Publish a message and keep it for queries."""
        self._payloads[stream] = payload
        self._bus.publish(stream, payload)
