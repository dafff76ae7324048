"""How tracking reaches mapping: in the same process, or in one of its own."""

from collections import deque
from typing import Protocol

from gazemap.slam.live.mapper import Mapper
from gazemap.slam.live.messages import Note, Reply


class MappingLink(Protocol):
    """Takes notes and gives one reply to each, in order."""

    def send(self, note: Note) -> None:
        """Hand over a note without waiting."""

    def poll(self) -> Reply | None:
        """Return the next reply if it is there."""

    def wait(self) -> Reply:
        """Return the next reply."""

    def close(self) -> None:
        """Stop mapping."""


class InlineLink:
    """Mapping in the caller's process: every note is worked in at once."""

    def __init__(self, mapper: Mapper) -> None:
        """Wrap a mapper."""
        self._mapper = mapper
        self._replies: deque[Reply] = deque()

    def send(self, note: Note) -> None:
        """Work a note in."""
        self._replies.append(self._mapper.handle(note))

    def poll(self) -> Reply | None:
        """Return the next reply if it is there."""
        return self._replies.popleft() if self._replies else None

    def wait(self) -> Reply:
        """Return the next reply."""
        return self._replies.popleft()

    def close(self) -> None:
        """Do nothing: there is no process."""
