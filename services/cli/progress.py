"""Progress of long work: a bar on a terminal, silence elsewhere."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from gazemap.ports import Progress


def _silent(stage: str, done: int, total: int) -> None:
    """Take a report and show nothing."""


@contextmanager
def progress_bar() -> Iterator[Progress]:
    """Yield what long work reports to; the bar is on stderr, so output can be piped."""
    if not sys.stderr.isatty():
        yield _silent
        return
    from rich.console import Console
    from rich.progress import Progress as Bar

    with Bar(console=Console(stderr=True), transient=True) as bar:
        tasks: dict[str, int] = {}

        def show(stage: str, done: int, total: int) -> None:
            if stage not in tasks:
                tasks[stage] = int(bar.add_task(stage))
            bar.update(task_id=tasks[stage], completed=done, total=total or None)  # type: ignore[arg-type]

        yield show
