"""`gazemap slam SESSION --out FILE.tum`: tracking and mapping alone."""

from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, Unpack

import click

from gazemap.ports import Session
from services.cli.progress import progress_bar

if TYPE_CHECKING:
    from gazemap.types.slam import SlamResult


class _TagOptions(TypedDict):
    tag_size: float | None
    survey_tags: Path | None


@click.command()
@click.argument("session", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="FILE.tum to write.")
@click.option("--camera", type=click.Path(path_type=Path), help="A camera file to use.")
@click.option("--live", is_flag=True, help="Write each pose as it was when its frame was tracked.")
@click.option("--no-tags", is_flag=True, help="Leave the tags out: the scale is arbitrary.")
@click.option(
    "--tag-size",
    type=click.FloatRange(min=0, min_open=True),
    help="Side in metres of tags that no layout places: it gives the scale.",
)
@click.option(
    "--survey-tags", type=click.Path(path_type=Path), help="tags.yaml to write: all tags in world."
)
def command(
    session: Path,
    *,
    out: Path,
    camera: Path | None,
    live: bool,
    no_tags: bool,
    **tags: Unpack[_TagOptions],
) -> None:
    """Track and map SESSION; write its path, and FILE.json with its frame, scale and map."""
    from gazemap.session.opening import open_session

    if live and any(value is not None for value in tags.values()):
        raise click.UsageError("--tag-size and --survey-tags want the whole recording, not --live")
    opened = open_session(session, camera=camera)
    if live:
        _live(opened, out, use_tags=not no_tags)
        return
    result = _offline(opened, out, use_tags=not no_tags, tag_size_m=tags["tag_size"])
    if tags["survey_tags"] is not None:
        _write_survey(opened, result, tags["survey_tags"], use_tags=not no_tags)


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


def _offline(
    session: Session, out: Path, *, use_tags: bool, tag_size_m: float | None
) -> "SlamResult":
    from gazemap.session.tum_file import write_tum
    from gazemap.slam.config import SlamConfig
    from gazemap.slam.offline import map_session

    config = SlamConfig(tag_size_m=tag_size_m)
    with progress_bar() as progress:
        result = map_session(session, config, progress=progress, use_tags=use_tags)
    write_tum(result.trajectory, out)
    for warning in result.warnings:
        click.echo(f"warning: {warning}", err=True)
    seen = len(result.outcomes)
    click.echo(
        f"{len(result.trajectory)} of {seen} frames tracked, {len(result.map.points_world)} points,"
        f" scale {result.trajectory.scale}"
    )
    return result


def _write_survey(session: Session, result: "SlamResult", path: Path, *, use_tags: bool) -> None:
    from gazemap.errors import InputError
    from gazemap.session.tag_file import write_tags
    from gazemap.slam.config import SlamConfig
    from gazemap.types.session import TagLayout

    layout = session.data.tags if use_tags else None
    known = layout.tags if layout is not None else ()
    family = layout.family if layout is not None else SlamConfig().tag_family
    if not (known or result.surveyed_tags):
        raise InputError(
            "no tag could be surveyed", where=session.data.name,
            todo="give --tag-size, and move around the tags",
        )  # fmt: skip
    write_tags(TagLayout(family=family, tags=(*known, *result.surveyed_tags)), path)
    click.echo(f"{len(result.surveyed_tags)} tags surveyed")
