"""Many sessions, each rebuilt by a process of its own: one that fails stops none of the others."""

import subprocess
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

from gazemap.errors import GazemapError, InputError


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
    with ThreadPoolExecutor(max_workers=jobs) as pool:
        running = {pool.submit(_run, job, options): job for job in work}
        for done in as_completed(running):
            code, line = done.result()
            failed += code != 0
            yield line
    if failed:
        raise GazemapError(f"{failed} of {len(work)} sessions failed; see their lines above")


def _run(job: Job, options: Mapping[str, object]) -> tuple[int, str]:
    given = {name: value for name, value in options.items() if value is not None}
    flags = [part for name, value in given.items() for part in (_flag(name), str(value))]
    command = [sys.executable, "-m", "services.cli", "rebuild", str(job.session)]
    done = subprocess.run(  # noqa: S603  our own interpreter, arguments as given
        [*command, "--out", str(job.out), *flags], capture_output=True, text=True, check=False
    )
    said = (done.stderr if done.returncode else done.stdout).strip().splitlines()
    return done.returncode, said[-1] if said else f"{job.session}: exit {done.returncode}"


def _flag(name: str) -> str:
    return "--" + name.replace("_", "-")
