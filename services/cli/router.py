"""`gazemap router`: a Zenoh router with the rules of `deploy/`."""

from pathlib import Path

import click

from services.lifetime import wait_for_stop
from services.router import DEFAULT_RULES, RouterConfig, running_router


@click.command()
@click.option("--config", "rules", type=click.Path(path_type=Path), default=DEFAULT_RULES)
@click.option("--listen", "endpoint", help="Listen here instead, such as tcp/127.0.0.1:7448.")
@click.option("--users", type=click.Path(path_type=Path), help="File of role:password lines.")
def command(rules: Path, endpoint: str | None, users: Path | None) -> None:
    """Route until interrupted; the rules are a Zenoh configuration file."""
    with running_router(RouterConfig(rules=rules, endpoint=endpoint, users=users)):
        click.echo("router ready", err=True)
        wait_for_stop()
