"""What a service needs of a bus, whatever carries it."""

import threading
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Protocol, Self

from services.bus.keys import LOSSY, Stream

# Two seconds of images: a hiccup costs none, a service that is too slow stays near the present.
_FRAME_LIMIT = 60


@dataclass(frozen=True, slots=True, kw_only=True)
class Message:
    """The bytes of one message and the stream they came on."""

    stream: Stream
    payload: bytes


class Inbox:
    """Messages of all of a service's subscriptions, in the order of arrival.

    A bus's callback only puts; one loop takes. Of each lossy stream at most a few wait: a service
    that falls behind skips the oldest images, and counts them, rather than fall further behind.
    """

    def __init__(self, *, frame_limit: int = _FRAME_LIMIT) -> None:
        """Limit how many messages of each lossy stream may wait."""
        self._waiting: deque[Message] = deque()
        self._changed = threading.Condition()
        self._frame_limit = frame_limit
        self.dropped: Counter[Stream] = Counter()

    def put(self, message: Message) -> None:
        """Take in a message; called from the bus's threads."""
        with self._changed:
            if message.stream in LOSSY:
                self._make_room(message.stream)
            self._waiting.append(message)
            self._changed.notify()

    def _make_room(self, stream: Stream) -> None:
        same = [each for each in self._waiting if each.stream is stream]
        if len(same) >= self._frame_limit:
            self._waiting.remove(same[0])
            self.dropped[stream] += 1

    def get(self, *, timeout_s: float) -> Message | None:
        """Return the oldest message, or None if none came in time."""
        with self._changed:
            if not self._waiting:
                self._changed.wait(timeout_s)
            return self._waiting.popleft() if self._waiting else None


Answer = Callable[[bytes], bytes]


class Bus(Protocol):
    """Publish, subscribe, ask and answer on the streams of one rig."""

    def publish(self, stream: Stream, payload: bytes) -> None:
        """Send a message; streams that are not lossy are kept for late and cut-off subscribers."""

    def subscribe(self, stream: Stream, inbox: Inbox) -> None:
        """Put every message of a stream into an inbox, those before the subscription included."""

    def answer(self, stream: Stream, handler: Answer) -> None:
        """Answer queries on a key, on a thread of their own."""

    def ask(self, stream: Stream, payload: bytes, *, timeout_s: float) -> bytes | None:
        """Return the first answer to a query, or None if there was none in time."""

    def announce(self, service: str) -> None:
        """Show that a service lives, until the bus is closed."""

    def alive(self) -> frozenset[str]:
        """Return the names of the services that live."""

    def close(self) -> None:
        """Leave the bus."""

    def __enter__(self) -> Self:
        """Return the bus."""

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the bus."""
