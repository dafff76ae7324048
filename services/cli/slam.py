"""`gazemap slam SESSION --out FILE.tum`: tracking and mapping alone."""

from pathlib import Path

import click

from gazemap.ports import Session
from services.cli.progress import progress_bar


@click.command()
@click.argument("session", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="FILE.tum to write.")
@click.option("--camera", type=click.Path(path_type=Path), help="A camera file to use.")
@click.option("--live", is_flag=True, help="Write each pose as it was when its frame was tracked.")
@click.option("--no-tags", is_flag=True, help="Leave the tags out: the scale is arbitrary.")
def command(session: Path, *, out: Path, camera: Path | None, live: bool, no_tags: bool) -> None:
    """Track and map SESSION; write its path, and FILE.json with its frame, scale and map."""
    from gazemap.session.opening import open_session

    opened = open_session(session, camera=camera)
    if live:
        _live(opened, out, use_tags=not no_tags)
    else:
        _offline(opened, out, use_tags=not no_tags)


def _live(session: Session, out: Path, *, use_tags: bool) -> None:
    import numpy as np

    from gazemap.session.tum_file import write_tum
    from gazemap.slam.live.config import LiveConfig
    from gazemap.slam.live.recording import track_recording

    with progress_bar() as progress:
        result = track_recording(
            session,
            LiveConfig(),
            use_tags=use_tags,
            rng=np.random.default_rng(0),
            progress=progress,
        )
    write_tum(result.trajectory, out)
    for event in result.events:
        click.echo(f"{event.t_ns}: {event.kind}, map {event.map_id}", err=True)
    click.echo(
        f"{len(result.trajectory)} of {result.frame_count} frames tracked, "
        f"{result.point_count} points, scale {result.trajectory.scale}"
    )


def _offline(session: Session, out: Path, *, use_tags: bool) -> None:
    from gazemap.session.tum_file import write_tum
    from gazemap.slam.config import SlamConfig
    from gazemap.slam.offline import map_session

    with progress_bar() as progress:
        result = map_session(session, SlamConfig(), progress=progress, use_tags=use_tags)
    write_tum(result.trajectory, out)
    for warning in result.warnings:
        click.echo(f"warning: {warning}", err=True)
    seen = len(result.outcomes)
    click.echo(
        f"{len(result.trajectory)} of {seen} frames tracked, {len(result.map.points_world)} points,"
        f" scale {result.trajectory.scale}"
    )
