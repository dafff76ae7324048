"""Stages that are finished once: a rebuild that was stopped goes on from what is there.

Each finished stage is a folder `OUT/.stages/NAME` that appears whole or not at all. It holds the
stage's result and a key; the result counts only while the key still says the same input, options
and code.
"""

import hashlib
import json
import pickle
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Generic, TypeVar

import gazemap
import grounding
from gazemap.session.atomic import whole_folder

T = TypeVar("T")


class Status(StrEnum):
    """How a stage ended."""

    OK = "ok"
    WARNING = "warning"
    ERROR = "error"


@dataclass(frozen=True, slots=True, kw_only=True)
class StageReport:
    """What summary.json says of a stage."""

    status: Status
    messages: tuple[str, ...]
    seconds: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome(Generic[T]):
    """A stage's result with what the user should know about it."""

    result: T
    messages: tuple[str, ...] = ()


@dataclass(slots=True, kw_only=True)
class Stages:
    """Runs stages in order, each keyed by all that went before it.

    Attributes:
        folder: where finished stages are kept.
        key: digest of the input, the code and every option used so far.
        reports: what was run or found finished, by name.
    """

    folder: Path
    key: str
    reports: dict[str, StageReport] = field(default_factory=dict)

    def run(self, name: str, work: Callable[[], Outcome[T]], *, options: object = None) -> T:
        """Return the stage's result, from its folder where that is finished and still true."""
        self.key = _digest([self.key, name, repr(options)])
        finished: tuple[T, StageReport] | None = self._finished(name)
        if finished is None:
            finished = self._compute(name, work)
        result, self.reports[name] = finished
        return result

    def _finished(self, name: str) -> tuple[T, StageReport] | None:
        place = self.folder / name
        try:
            marker = json.loads((place / "stage.json").read_text())
        except (OSError, ValueError):
            return None
        if marker["key"] != self.key:
            return None
        report = StageReport(
            status=Status(marker["status"]),
            messages=tuple(marker["messages"]),
            seconds=marker["seconds"],
        )
        result: T = pickle.loads((place / "result").read_bytes())  # noqa: S301  only ours is read
        return result, report

    def _compute(self, name: str, work: Callable[[], Outcome[T]]) -> tuple[T, StageReport]:
        start = time.monotonic()
        outcome = work()
        status = Status.WARNING if outcome.messages else Status.OK
        seconds = round(time.monotonic() - start, 3)
        report = StageReport(status=status, messages=outcome.messages, seconds=seconds)
        marker = {
            "key": self.key,
            "status": status,
            "messages": list(outcome.messages),
            "seconds": seconds,
        }
        with whole_folder(self.folder / name) as partial:
            (partial / "result").write_bytes(pickle.dumps(outcome.result))
            (partial / "stage.json").write_text(json.dumps(marker))
        return outcome.result, report


def input_key(session: Path) -> str:
    """Return a digest of a recording's files (names, sizes, times) and of our own code."""
    files = sorted(session.rglob("*")) if session.is_dir() else [session]
    facts = [(str(f), f.stat().st_size, f.stat().st_mtime_ns) for f in files if f.is_file()]
    return _digest([repr(facts), _code_key()])


def _code_key() -> str:
    roots = [Path(package.__file__).parent for package in (gazemap, grounding) if package.__file__]
    sources = sorted(path for root in roots for path in root.rglob("*.py"))
    return _digest([path.read_text() for path in sources])


def _digest(parts: list[str]) -> str:
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()
