"""Child processes that never outlive the process that started them, however that one ends.

The child's standard input is a pipe that only its parent holds open. When the parent is gone, even
killed, the child reads the pipe's end and stops as if it had been asked to.
"""

import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from typing import IO, Final

_IS_CHILD: Final = "GAZEMAP_STOPS_WITH_PARENT"
_ORDERLY_END_S: Final = 10.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Child:
    """A console command that runs beside this process, for as long as this record is held."""

    process: subprocess.Popen[str]
    lifeline: IO[bytes]

    def stop(self) -> None:
        """End the process and wait for it; one that does not listen is killed."""
        self.process.terminate()
        try:
            self.process.wait(_ORDERLY_END_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.lifeline.close()


def start(*arguments: str, stdout: IO[str] | int, stderr: IO[str] | int) -> Child:
    """Start `gazemap ARGUMENTS`."""
    read_end, write_end = os.pipe()
    lifeline = os.fdopen(write_end, "wb", buffering=0)
    try:
        process = subprocess.Popen(  # noqa: S603  our own interpreter
            [sys.executable, "-m", "services.cli", *arguments],
            stdin=read_end,
            stdout=stdout,
            stderr=stderr,
            text=True,
            env=os.environ | {_IS_CHILD: "1", "PYTHONUNBUFFERED": "1"},
        )
    finally:
        os.close(read_end)
    return Child(process=process, lifeline=lifeline)


def stop_with_parent() -> None:
    """In a process of `start`: stop when the parent is gone; elsewhere do nothing."""
    if os.environ.pop(_IS_CHILD, None):
        threading.Thread(target=_watch, name="lifeline", daemon=True).start()


def _watch() -> None:
    os.read(sys.stdin.fileno(), 1)
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(_ORDERLY_END_S)
    os._exit(1)
