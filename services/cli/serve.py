"""`gazemap serve mapping|grounding`: a service, until it is interrupted."""

import threading
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import click

from gazemap.config import load_config
from services.bus.zenoh import ZenohConfig

Choose = Callable[[ZenohConfig], ZenohConfig]


@click.command()
@click.argument("service", type=click.Choice(["mapping", "grounding"]))
@click.option("--config", type=click.Path(path_type=Path), help="TOML; see docs/services.md.")
@click.option("--connect", help="Where the router listens, over what the file says.")
@click.option("--rig", help="Name of the rig, over what the file says.")
def command(service: str, *, config: Path | None, connect: str | None, rig: str | None) -> None:
    """Run a service; it waits for the router and for the rig."""
    from services.lifetime import stop_on_signals

    stop = stop_on_signals()
    run = _mapping if service == "mapping" else _grounding
    run(stop, config, partial(_chosen, connect=connect, rig=rig))


def _mapping(stop: threading.Event, config: Path | None, choose: Choose) -> None:
    from services.bus.zenoh import connect
    from services.mapping import MappingService, MappingServiceConfig

    settings = MappingServiceConfig()
    if config is not None:
        settings = load_config(MappingServiceConfig, config)
    bus = connect(choose(settings.bus), stop=stop)
    if bus is not None:
        with bus:
            MappingService(bus, settings).run(stop)


def _grounding(stop: threading.Event, config: Path | None, choose: Choose) -> None:
    from services.bus.zenoh import connect
    from services.grounding import GroundingService, GroundingServiceConfig

    settings = GroundingServiceConfig()
    if config is not None:
        settings = load_config(GroundingServiceConfig, config)
    bus = connect(choose(settings.bus), stop=stop)
    if bus is not None:
        with bus:
            GroundingService(bus, settings).run(stop)


def _chosen(bus: ZenohConfig, *, connect: str | None, rig: str | None) -> ZenohConfig:
    return replace(bus, endpoint=connect or bus.endpoint, rig=rig or bus.rig)
