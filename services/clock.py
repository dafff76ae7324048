"""Time as a service sees it, so that tests need not wait."""

import threading
import time
from typing import Protocol


class Clock(Protocol):
    """A clock that can be waited on."""

    def now_s(self) -> float:
        """Return the time since some moment."""

    def wait_until(self, when_s: float) -> bool:
        """Wait for a time; return at once, with False, when the process is to stop."""


class WallClock:
    """The machine's clock."""

    def __init__(self, stop: threading.Event) -> None:
        """Wait no longer once `stop` is set."""
        self._stop = stop

    def now_s(self) -> float:
        """Return the time since some moment."""
        return time.monotonic()

    def wait_until(self, when_s: float) -> bool:
        """Wait for a time; return at once, with False, when the process is to stop."""
        left_s = when_s - time.monotonic()
        return not (self._stop.wait(left_s) if left_s > 0 else self._stop.is_set())
