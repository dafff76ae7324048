"""A bus inside one process: for tests and for running both services in one program."""

import logging
from collections import defaultdict
from dataclasses import dataclass, field
from types import TracebackType
from typing import Self

from services.bus.base import Answer, Inbox, Message
from services.bus.keys import LOSSY, Stream

_log = logging.getLogger(__name__)


@dataclass(slots=True)
class Exchange:
    """What the buses of one process share."""

    kept: list[Message] = field(default_factory=list)
    inboxes: dict[Stream, list[Inbox]] = field(default_factory=lambda: defaultdict(list))
    handlers: dict[Stream, Answer] = field(default_factory=dict)
    services: set[str] = field(default_factory=set)


class MemoryBus:
    """One participant of an exchange."""

    def __init__(self, exchange: Exchange) -> None:
        self._exchange = exchange
        self._announced: set[str] = set()

    def publish(self, stream: Stream, payload: bytes) -> None:
        """Hand a message to every subscriber."""
        message = Message(stream=stream, payload=payload)
        if stream not in LOSSY:
            self._exchange.kept.append(message)
        for inbox in self._exchange.inboxes[stream]:
            inbox.put(message)

    def subscribe(self, stream: Stream, inbox: Inbox) -> None:
        """Put what was kept and what is to come into an inbox."""
        for message in self._exchange.kept:
            if message.stream is stream:
                inbox.put(message)
        self._exchange.inboxes[stream].append(inbox)

    def answer(self, stream: Stream, handler: Answer) -> None:
        """Answer queries on a key."""
        self._exchange.handlers[stream] = handler

    def ask(self, stream: Stream, payload: bytes, *, timeout_s: float) -> bytes | None:  # noqa: ARG002  a call takes no time
        """Return the answer, or None where nobody answers."""
        handler = self._exchange.handlers.get(stream)
        try:
            return None if handler is None else handler(payload)
        except Exception:  # noqa: BLE001  a service's boundary, as over Zenoh
            _log.exception("query on %s failed", stream)
            return None

    def announce(self, service: str) -> None:
        """Show that a service lives."""
        self._announced.add(service)
        self._exchange.services.add(service)

    def alive(self) -> frozenset[str]:
        """Return the names of the services that live."""
        return frozenset(self._exchange.services)

    def close(self) -> None:
        """Leave the exchange."""
        self._exchange.services -= self._announced

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
