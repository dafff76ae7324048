"""How a service is: counted, and said four times a second."""

import logging
import time
from collections import Counter, deque
from collections.abc import Callable, Mapping
from typing import Final

from gazemap.types.status import Level, ServiceStatus
from gazemap.wire.mapping import encode_status
from gazemap.wire.streams import Stream
from services.bus.base import Bus

_PERIOD_S: Final = 0.25
_KEPT_COMPLAINTS: Final = 20
_LOGGED_COMPLAINTS: Final = 1000
FINISHED: Final = "finished"
IS_METRIC: Final = "is_metric"
SENT: Final = "sent"
_log = logging.getLogger(__name__)
Figures = Callable[[], Mapping[str, float]]


class Health:
    """Keeps what a service says of itself and publishes it."""

    def __init__(self, bus: Bus, *, service: str, stream: Stream) -> None:
        self._bus, self._service, self._stream = bus, service, stream
        self._complaints: deque[str] = deque(maxlen=_KEPT_COMPLAINTS)
        self._logged: deque[str] = deque(maxlen=_LOGGED_COMPLAINTS)
        self._counts: Counter[str] = Counter()
        self._last_s = -_PERIOD_S
        self._has_failed = False
        self.t_ns = 0

    @property
    def level(self) -> Level:
        """How the service does."""
        if self._has_failed:
            return Level.ERROR
        return Level.WARNING if self._complaints else Level.OK

    def restart(self, session: str) -> None:
        """Begin to count anew for another session."""
        _log.info("session %s begins", session)
        self._complaints.clear()
        self._logged.clear()
        self._has_failed = False
        self._counts.clear()
        self.t_ns = 0

    def reached(self, t_ns: int) -> None:
        """Note the time in the session that the service has come to."""
        self.t_ns = t_ns

    def count(self, what: str) -> None:
        """Count one more of something."""
        self._counts[what] += 1

    def complain(self, line: str) -> None:
        """Note that an input could not be used; the same line again is only counted."""
        self._counts["refused"] += 1
        if line not in self._complaints:
            self._complaints.append(line)
        if line not in self._logged:
            _log.warning("%s", line)
            self._logged.append(line)

    def fail(self, error: Exception, *, what: str) -> None:
        """Note an error that nobody foresaw: the service goes on, and says that it has failed."""
        _log.error("%s failed", what, exc_info=error)
        self._has_failed = True
        self.complain(f"{what}: unexpected {type(error).__name__}: {error}; see the service's log")

    def beat(self, figures: Figures) -> None:
        """Publish the status if it is time."""
        now_s = time.monotonic()
        if now_s - self._last_s >= _PERIOD_S:
            self._last_s = now_s
            self._say(figures())

    def finish(self, figures: Figures) -> None:
        """Say that a session has come to its end."""
        self._say({**figures(), FINISHED: 1.0})

    def _say(self, figures: Mapping[str, float]) -> None:
        counted = {name: float(n) for name, n in self._counts.items()}
        status = ServiceStatus(
            service=self._service,
            t_ns=self.t_ns,
            level=self.level,
            messages=tuple(self._complaints),
            figures={**counted, **figures},
        )
        self._bus.publish(self._stream, encode_status(status))
