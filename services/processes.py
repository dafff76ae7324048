"""Services as child processes of one program: started together, ended together."""

import subprocess
from pathlib import Path
from types import TracebackType
from typing import Self

from gazemap.errors import GazemapError
from services import children


class ServiceProcesses:
    """Console commands run beside this process; each writes its log to a file."""

    def __init__(self, log_folder: Path) -> None:
        """Keep the logs in a folder."""
        self._log_folder = log_folder
        self._running: dict[str, children.Child] = {}
        log_folder.mkdir(parents=True, exist_ok=True)

    def start(self, name: str, *arguments: str) -> None:
        """Start `gazemap ARGUMENTS`."""
        with (self._log_folder / f"{name}.log").open("w") as log:
            self._running[name] = children.start(*arguments, stdout=log, stderr=subprocess.STDOUT)

    def has_ended(self, name: str) -> bool:
        """Return whether a process has ended; one that failed is an error.

        Raises:
            GazemapError: if it ended with another code than 0, with its last line.
        """
        code = self._running[name].process.poll()
        if code:
            log = self._log_folder / f"{name}.log"
            last = (log.read_text(errors="replace").strip().splitlines() or ["no message"])[-1]
            raise GazemapError(f"{name} ended with code {code}: {last}; see {log}")
        return code is not None

    def check(self) -> None:
        """Raise GazemapError if any process has failed."""
        for name in self._running:
            self.has_ended(name)

    def stop(self) -> None:
        """End all processes, the last one started first; one that does not listen is killed."""
        for child in reversed(self._running.values()):
            child.stop()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()
