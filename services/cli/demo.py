"""`gazemap demo`: simulate a session, run both services on it, print the plan as it arrives."""

import secrets
from pathlib import Path
from typing import Final

import click

from services.cli.progress import progress_bar

# In a file there is room for a table of whole lines.
_FILE_WIDTH: Final = 140


@click.command()
@click.option("--out", type=click.Path(path_type=Path), default=Path("demo-out"), show_default=True)
@click.option("--seed", type=int, help="Of the simulation; drawn anew and printed if not given.")
@click.option("--seconds", type=float, default=15.0, show_default=True)
@click.option(
    "--level", type=click.Choice(["easy", "medium", "hard"]), default="easy", show_default=True
)
def command(out: Path, seed: int | None, seconds: float, level: str) -> None:
    """Simulate a demonstration, ground it live over loopback Zenoh, and rebuild it into OUT."""
    from rich.console import Console

    from gazemap.sim.config import Level
    from services.cli.plan_table import plan_table
    from services.demo import DemoConfig, Plan, run_demo

    console = Console()
    if not console.is_terminal:
        console = Console(width=_FILE_WIDTH)
    chosen = secrets.randbelow(1_000_000) if seed is None else seed
    console.print(f"seed {chosen}: simulating, while the services start")
    shown: dict[int, str] = {}

    def watch(plan: Plan) -> None:
        for each in plan["instructions"]:
            if shown.get(each["index"]) != each["status"]:
                shown[each["index"]] = each["status"]
                line = f"revision {plan['revision']}: {each['index']} {each['sentence']!r}"
                console.print(f"{line} is {each['status']}", highlight=False)

    config = DemoConfig(seed=chosen, seconds=seconds, level=Level(level))
    with progress_bar() as progress:
        plan = run_demo(out, config, progress=progress, watch=watch)
    console.print(plan_table(plan))
    console.print(f"rebuilt into {out}: open {out / 'report.html'}")
