"""`gazemap simulate`: write a session of a simulated person and the truth about it."""

from dataclasses import asdict
from pathlib import Path
from typing import Final

import click

from gazemap.config import build_record
from gazemap.sim.config import LENSES, Level, SimConfig, preset
from gazemap.sim.vocabulary import COLOURS_BGR, SHAPES, Relation
from services.cli.progress import progress_bar

# Where an option lands in the configuration; an option that is not given changes nothing.
_PLACES: Final[dict[str, tuple[str, ...]]] = {
    "seed": ("seed",),
    "seconds": ("seconds",),
    "gaze_rate_hz": ("gaze_rate_hz",),
    "overhead": ("has_overhead",),
    "fps": ("scene_lens", "rate_hz"),
    "overhead_fps": ("overhead_lens", "rate_hz"),
    "objects": ("tabletop", "object_count"),
    "colours": ("tabletop", "colours"),
    "shapes": ("tabletop", "shapes"),
    "relations": ("tabletop", "relations"),
    "grain": ("tabletop", "grain_contrast"),
    "hand": ("person", "has_hand"),
    "gaze_noise_deg": ("person", "gaze_noise_deg"),
    "gaze_offset_deg": ("person", "gaze_offset_deg"),
    "speech_delay_s": ("person", "speech_delay_s"),
    "readout_s": ("imaging", "readout_s"),
    "exposure_s": ("imaging", "exposure_s"),
    "light_change": ("imaging", "light_change"),
}


@click.command()
@click.argument("out", type=click.Path(path_type=Path))
@click.option("--seed", type=int, help="Equal seeds give equal sessions; 0 if not given.")
@click.option("--seconds", type=float, help="Length of the session; 20 if not given.")
@click.option(
    "--level",
    type=click.Choice([str(level) for level in Level]),
    default=str(Level.EASY),
    show_default=True,
    help="medium: an arm, 0.8 degrees off; hard: also rolling shutter, blur, changing light.",
)
@click.option("--size", nargs=2, type=int, help="Width and height of scene.mp4; 800 600.")
@click.option("--overhead-size", nargs=2, type=int, help="Of overhead.mp4; 960 720.")
@click.option("--fps", type=float, help="Frames a second of scene.mp4; 30.")
@click.option("--overhead-fps", type=float, help="Of overhead.mp4; 10.")
@click.option("--overhead/--no-overhead", default=None, help="With a camera above the table.")
@click.option("--lens", type=click.Choice(sorted(LENSES)), help="Of the scene camera; pinhole8.")
@click.option("--gaze-rate-hz", type=float, help="Rate of the eye tracker; 200.")
@click.option("--gaze-noise-deg", type=float, help="White noise of a gaze sample.")
@click.option("--gaze-offset-deg", type=float, help="Constant error of the eye tracker.")
@click.option("--hand/--no-hand", default=None, help="An arm carries the things, or they fly.")
@click.option("--speech-delay-s", type=float, help="From an action's start to its sentence.")
@click.option("--readout-s", type=float, help="Rolling shutter, first row to last.")
@click.option("--exposure-s", type=float, help="Exposure of a row: motion blur.")
@click.option("--light-change", type=float, help="Relative changes of brightness.")
@click.option("--grain", type=float, help="Contrast of the table's grain, 0 to 1.")
@click.option("--objects", type=int, help="How many things are on the table; 8.")
@click.option("--colours", help=f"Separated by commas, of: {', '.join(COLOURS_BGR)}.")
@click.option("--shapes", help=f"Separated by commas, of: {', '.join(SHAPES)}.")
@click.option("--relations", help=f"Separated by commas, of: {', '.join(Relation)}.")
def command(out: Path, level: str, **options: object) -> None:
    """Write OUT/session, as glasses would record it, and OUT/truth."""
    from gazemap.sim.simulate import simulate

    config = _configured(Level(level), options)
    with progress_bar() as progress:
        simulate(config, out, progress=progress)


def _configured(level: Level, options: dict[str, object]) -> SimConfig:
    """Return a level's preset with the given options over it."""
    values = asdict(preset(level))
    for name, place in _PLACES.items():
        given = options[name]
        if given is not None:
            _put(values, place, tuple(given.split(",")) if isinstance(given, str) else given)
    for name, lens in (("size", "scene_lens"), ("overhead_size", "overhead_lens")):
        size = options[name]
        if isinstance(size, tuple):
            values[lens] |= {"width_px": size[0], "height_px": size[1]}
    if options["lens"] is not None:
        model, distortion = LENSES[str(options["lens"])]
        values["scene_lens"] |= {"model": model, "distortion": distortion}
    return build_record(SimConfig, values, where="simulate")


def _put(values: dict[str, object], place: tuple[str, ...], value: object) -> None:
    *tables, name = place
    for table in tables:
        inner = values[table]
        if isinstance(inner, dict):
            values = inner
    values[name] = value
