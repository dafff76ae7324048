"""How a process ends: on SIGINT or SIGTERM, in order."""

import signal
import threading
from types import FrameType


def stop_on_signals() -> threading.Event:
    """Return an event that SIGINT and SIGTERM set; the process then leaves its loop by itself."""
    stop = threading.Event()

    def ask_to_stop(_number: int, _frame: FrameType | None) -> None:
        stop.set()

    signal.signal(signal.SIGINT, ask_to_stop)
    signal.signal(signal.SIGTERM, ask_to_stop)
    return stop


def wait_for_stop() -> None:
    """Sleep until SIGINT or SIGTERM."""
    stop = stop_on_signals()
    # A wait without a time-out would not let the handler run until the next signal.
    while not stop.wait(0.5):
        continue
