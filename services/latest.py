"""Streams whose latest message can also be asked for."""

from collections.abc import Callable

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
        return lambda _asked: self._payloads.get(stream, b"")

    def publish(self, stream: Stream, payload: bytes) -> None:
        """Publish a message and keep it for queries."""
        self._payloads[stream] = payload
        self._bus.publish(stream, payload)
