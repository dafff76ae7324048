"""`gazemap rebuild SESSION... --out OUT`: sessions rebuilt offline."""

from pathlib import Path

import click

from services.cli.progress import progress_bar


@click.command()
@click.argument("sessions", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder to write.")
@click.option(
    "--gaze-offset",
    type=click.Choice(["auto", "off"]),
    default="auto",
    show_default=True,
    help="Look for the session's constant gaze error and take it out.",
)
@click.option(
    "--fixations",
    type=click.Choice(["device", "own"]),
    default="device",
    show_default=True,
    help="Use the device's fixations, or detect them from gaze.",
)
@click.option(
    "--narration-times",
    type=click.Choice(["on", "off"]),
    default="on",
    show_default=True,
    help="Use the transcript's times, or only its order.",
)
@click.option("--camera", type=click.Path(path_type=Path), help="A camera file to use.")
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True)
def command(
    sessions: tuple[Path, ...],
    *,
    out: Path,
    jobs: int,
    **options: object,
) -> None:
    """Rebuild SESSIONS into OUT, several into OUT/<session name>; run again, it goes on."""
    from services.rebuild.batch import rebuild_many

    if len(sessions) > 1:
        for line in rebuild_many(sessions, out, options=options, jobs=jobs):
            click.echo(line)
        return
    _rebuild_one(sessions[0], out, **options)


def _rebuild_one(session: Path, out: Path, **options: object) -> None:
    from gazemap.pipeline import FixationSource, MappingConfig, OffsetMode
    from services.rebuild.run import RebuildConfig, rebuild

    mapping = MappingConfig(
        source=FixationSource(str(options["fixations"])),
        offset_mode=OffsetMode(str(options["gaze_offset"])),
    )
    camera = options["camera"]
    config = RebuildConfig(
        mapping=mapping,
        with_narration_times=options["narration_times"] == "on",
        camera=camera if isinstance(camera, Path) else None,
    )
    with progress_bar() as progress:
        rebuilt = rebuild(session, out, config, progress=progress)
    plan = rebuilt.grounded.plan
    sure = sum(each.status.value == "grounded" for each in plan.instructions)
    click.echo(f"{out}: {sure} of {len(plan.instructions)} instructions grounded")
