"""`gazemap slam SESSION --out FILE.tum`: tracking and mapping alone."""

from pathlib import Path

import click

from services.cli.progress import progress_bar


@click.command()
@click.argument("session", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="FILE.tum to write.")
@click.option("--camera", type=click.Path(path_type=Path), help="A camera file to use.")
@click.option("--no-tags", is_flag=True, help="Leave the tags out: the scale is arbitrary.")
def command(session: Path, *, out: Path, camera: Path | None, no_tags: bool) -> None:
    """Track and map SESSION; write its path, and FILE.json with its frame, scale and map."""
    from gazemap.session.opening import open_session
    from gazemap.session.tum_file import write_tum
    from gazemap.slam.config import SlamConfig
    from gazemap.slam.offline import map_session

    opened = open_session(session, camera=camera)
    with progress_bar() as progress:
        result = map_session(opened, SlamConfig(), progress=progress, use_tags=not no_tags)
    write_tum(result.trajectory, out)
    for warning in result.warnings:
        click.echo(f"warning: {warning}", err=True)
    seen = len(result.outcomes)
    click.echo(
        f"{len(result.trajectory)} of {seen} frames tracked, {len(result.map.points_world)} points,"
        f" scale {result.trajectory.scale}"
    )
