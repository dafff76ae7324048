"""`gazemap replay SESSION`: publish a recording as a rig would."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from services.replayer import ReplayConfig


@click.command()
@click.argument("session", type=click.Path(path_type=Path))
@click.option(
    "--rate",
    type=click.FloatRange(min=0, min_open=True),
    help="How much faster than recorded; 1 by default.",
)
@click.option(
    "--max-lead-s",
    type=click.FloatRange(min=0.1),
    help="Wait for a mapping service that is further behind; without it, as a rig, it never waits.",
)
@click.option("--connect", help="Where the router listens, over what the file says.")
@click.option("--config", "file", type=click.Path(path_type=Path), help="TOML file.")
@click.option("--camera", type=click.Path(path_type=Path), help="Camera file to use instead.")
def command(session: Path, *, file: Path | None, camera: Path | None, **options: Any) -> None:  # noqa: ANN401
    """Publish a recording on the bus, every message at its time."""
    from gazemap.config import load_config
    from gazemap.errors import InputError
    from gazemap.session import open_session
    from services.bus.zenoh import connect
    from services.cli.progress import progress_bar
    from services.clock import WallClock
    from services.lifetime import stop_on_signals
    from services.replayer import ReplayConfig, replay, wait_for_services

    config = load_config(ReplayConfig, file) if file else ReplayConfig()
    config = _over(config, **options)
    recording = open_session(session, camera=camera)
    stop = stop_on_signals()
    clock, bus = WallClock(stop), connect(config.bus, stop=stop)
    if bus is None:
        sys.exit(1)
    with bus:
        missing = wait_for_services(bus, config=config, clock=clock)
        if missing:
            raise InputError(
                f"not there: {', '.join(sorted(missing))}",
                where=config.bus.endpoint,
                todo="start `gazemap serve`, or leave them out of wait_for",
            )
        with progress_bar() as progress:
            report = replay(recording, bus, config=config, clock=clock, progress=progress)
    for warning in recording.data.warnings:
        click.echo(f"warning: {warning}", err=True)
    ending = "" if report.is_whole else ", stopped before the end"
    click.echo(
        f"{report.message_count} messages, at most {report.worst_delay_s:.2f} s late{ending}"
    )


def _over(
    config: "ReplayConfig", *, rate: float | None, max_lead_s: float | None, connect: str | None
) -> "ReplayConfig":
    """Return the configuration with what was said on the command line over it."""
    return replace(
        config,
        rate=config.rate if rate is None else rate,
        max_lead_s=config.max_lead_s if max_lead_s is None else max_lead_s,
        bus=config.bus if connect is None else replace(config.bus, endpoint=connect),
    )
