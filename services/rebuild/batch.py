"""Many sessions, each rebuilt by a process of its own: one that fails stops none of the others."""

import subprocess
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

from gazemap.errors import GazemapError, InputError
from services import children


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """One session and the folder its rebuild goes to."""

    session: Path
    out: Path


def jobs_of(sessions: Sequence[Path], out: Path) -> tuple[Job, ...]:
    """Return a job for each session, `OUT/<session name>` each.

    Sessions of the same name (`a/session`, `b/session`) are told apart by their parents:
    `OUT/a-session`, `OUT/b-session`.

    Raises:
        InputError: if a session is given twice.
    """
    names = [path.resolve().stem if path.is_file() else path.resolve().name for path in sessions]
    often = Counter(names)
    jobs = [
        Job(session=path, out=out / (name if often[name] == 1 else f"{_parent(path)}-{name}"))
        for path, name in zip(sessions, names, strict=True)
    ]
    seen: set[Path] = set()
    for job in jobs:
        if job.out in seen:
            todo = "give each session once, or rename one"
            raise InputError(f"two sessions would go to {job.out}", where=job.session, todo=todo)
        seen.add(job.out)
    return tuple(jobs)


def _parent(path: Path) -> str:
    return path.resolve().parent.name


def rebuild_many(
    sessions: Sequence[Path], out: Path, *, options: Mapping[str, object], jobs: int
) -> Iterator[str]:
    """Rebuild every session, `jobs` at a time; yield a line for each as it ends.

    Raises:
        GazemapError: at the end, if any session failed; the others are finished.
    """
    work = jobs_of(sessions, out)
    failed = 0
    batch = _Batch()
    with ThreadPoolExecutor(max_workers=jobs) as pool:
        running = {pool.submit(batch.run, job, options): job for job in work}
        try:
            for done in as_completed(running):
                code, line = done.result()
                failed += code != 0
                yield line
        except BaseException:
            # Interrupted: none that waits may begin, and those that run are asked to end.
            pool.shutdown(wait=False, cancel_futures=True)
            batch.stop()
            raise
    if failed:
        raise GazemapError(f"{failed} of {len(work)} sessions failed; see their lines above")


class _Batch:
    """The processes that run now."""

    def __init__(self) -> None:
        self._running: set[children.Child] = set()

    def run(self, job: Job, options: Mapping[str, object]) -> tuple[int, str]:
        """Rebuild a session in a process of its own; return its exit code and what it said last."""
        given = {name: value for name, value in options.items() if value is not None}
        flags = [part for name, value in given.items() for part in (_flag(name), str(value))]
        child = children.start(
            "rebuild", str(job.session), "--out", str(job.out), *flags,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip
        self._running.add(child)
        out, err = child.process.communicate()
        self._running.discard(child)
        child.stop()
        said = (err if child.process.returncode else out).strip().splitlines()
        code = child.process.returncode
        return code, said[-1] if said else f"{job.session}: exit {code}"

    def stop(self) -> None:
        """Ask all that run to end."""
        for child in tuple(self._running):
            child.process.terminate()


def _flag(name: str) -> str:
    return "--" + name.replace("_", "-")
