"""`gazemap replay SESSION`: publish a recording as a rig would."""

from dataclasses import replace
from pathlib import Path

import click


@click.command()
@click.argument("session", type=click.Path(path_type=Path))
@click.option(
    "--rate",
    type=click.FloatRange(min=0, min_open=True),
    help="How much faster than recorded; 1 by default.",
)
@click.option("--config", "file", type=click.Path(path_type=Path), help="TOML file.")
@click.option("--camera", type=click.Path(path_type=Path), help="Camera file to use instead.")
def command(session: Path, rate: float | None, file: Path | None, camera: Path | None) -> None:
    """Publish a recording on the bus, every message at its time."""
    from gazemap.config import load_config
    from gazemap.errors import InputError
    from gazemap.session import open_session
    from services.bus.zenoh import ZenohBus
    from services.clock import WallClock
    from services.lifetime import stop_on_signals
    from services.replayer import ReplayConfig, replay, wait_for_services

    config = load_config(ReplayConfig, file) if file else ReplayConfig()
    if rate is not None:
        config = replace(config, rate=rate)
    recording = open_session(session, camera=camera)
    clock = WallClock(stop_on_signals())
    with ZenohBus(config.bus) as bus:
        missing = wait_for_services(bus, config=config, clock=clock)
        if missing:
            raise InputError(
                f"not there: {', '.join(sorted(missing))}",
                where=config.bus.endpoint,
                todo="start `gazemap serve`, or leave them out of wait_for",
            )
        report = replay(recording, bus, config=config, clock=clock)
    for warning in recording.data.warnings:
        click.echo(f"warning: {warning}", err=True)
    ending = "" if report.is_whole else ", stopped before the end"
    click.echo(
        f"{report.message_count} messages, at most {report.worst_delay_s:.2f} s late{ending}"
    )
