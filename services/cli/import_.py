"""`gazemap import SRC OUT.mcap`: turn any recording into the native one."""

from pathlib import Path

import click

from gazemap.session.opening import SessionFormat
from services.cli.progress import progress_bar

_FORMATS = [each.value for each in SessionFormat if each is not SessionFormat.MCAP]


@click.command()
@click.argument("source", metavar="SRC", type=click.Path(path_type=Path))
@click.argument("out", metavar="OUT.mcap", type=click.Path(path_type=Path))
@click.option(
    "--format", "name", type=click.Choice(_FORMATS), help="Found out from the source by default."
)
@click.option("--camera", type=click.Path(path_type=Path), help="Camera file to use instead.")
def command(source: Path, out: Path, name: str | None, camera: Path | None) -> None:
    """Write a recording of another format as one MCAP file."""
    from gazemap.session.mcap_write import write_mcap
    from gazemap.session.opening import detect_format, open_as

    session_format = detect_format(source) if name is None else SessionFormat(name)
    session = open_as(source, session_format=session_format, camera=camera)
    with progress_bar() as progress:
        write_mcap(session, out, progress=progress)
    for warning in session.data.warnings:
        click.echo(f"warning: {warning}", err=True)
    click.echo(f"{out}: {len(session.scene_t_ns)} scene frames from {session_format}")
