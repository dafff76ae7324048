"""What the page shows of a rebuild, picture by picture."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from gazemap.geometry.arrays import ImageArray
from gazemap.scene.crops import PosedCamera
from gazemap.types.tracking import Scale
from grounding.symbols.picture import draw_symbol
from services.report.page import Picture, Section, write_page
from services.report.picture import png_bytes
from services.report.plan_pictures import timeline_figure
from services.report.scene_pictures import overhead_picture, surface_pictures, table_figure

if TYPE_CHECKING:
    from services.rebuild.run import Rebuilt

_PATCHES_SHOWN = 60


def write_report(rebuilt: "Rebuilt", summary: Mapping[str, Any], path: Path) -> None:
    """Write report.html, one self-contained page."""
    plan = rebuilt.grounded.plan.to_json()
    sections = [
        _timeline(rebuilt, plan),
        _scene(rebuilt),
        *_overhead(rebuilt),
        _patches(rebuilt),
        _words(rebuilt),
    ]
    shown = [section for section in sections if section.pictures]
    write_page(path, summary=summary, plan=plan, sections=shown)


def _timeline(rebuilt: "Rebuilt", plan: Mapping[str, Any]) -> Section:
    instructions: Sequence[Mapping[str, Any]] = plan["instructions"]
    figure = timeline_figure(instructions, rebuilt.mapped.looks.fixations, rebuilt.memberships)
    picture = Picture(title="inferred segments and fixations", png=png_bytes(figure))
    note = "When each instruction was carried out, as the fixations tell; idle looks are grey."
    return Section(heading="Time", note=note, pictures=[picture])


def _scene(rebuilt: "Rebuilt") -> Section:
    mapped = rebuilt.mapped
    fixations, trajectory = mapped.looks.fixations, mapped.located.slam.trajectory
    unit = "m" if trajectory.scale is Scale.METRIC else "arbitrary units"
    sides = surface_pictures(mapped.scene, trajectory, fixations)
    table = table_figure(mapped.scene, fixations, rebuilt.memberships, unit=unit)
    title = "the surface from the {}: the head camera's path in grey, fixations in orange"
    pictures = [
        Picture(title=title.format(side), png=_png(drawn))
        for side, drawn in zip(("left", "right"), sides, strict=True)
    ]
    pictures.append(Picture(title="the table from above", png=png_bytes(table)))
    return Section(heading="Scene", note=f"World, lengths in {unit}.", pictures=pictures)


def _overhead(rebuilt: "Rebuilt") -> list[Section]:
    mapped = rebuilt.mapped
    first = next(iter(mapped.session.overhead_frames()), None)
    camera, T_world_overhead = mapped.session.overhead_camera, mapped.located.T_world_overhead
    if first is None or camera is None or T_world_overhead is None:
        return []
    view = PosedCamera.of(camera, T_world_overhead, is_overhead=True)
    looks, members = mapped.looks.fixations, rebuilt.memberships
    drawn = overhead_picture(first.image, view, mapped.scene, looks, members)
    note = (
        "The overhead camera's first image: objects where they stood then, all fixations with "
        "their 95 % ellipses, coloured by instruction."
    )
    pictures = [Picture(title="overhead view", png=_png(drawn))]
    return [Section(heading="Overhead view", note=note, pictures=pictures)]


def _patches(rebuilt: "Rebuilt") -> Section:
    cut = [each for each in rebuilt.grounded.patches if each.image_bgr is not None]
    kept = [each for each in cut if each.kept]
    step = max(1, -(-len(kept) // _PATCHES_SHOWN))
    pictures = [
        Picture(title=f"{each.instruction}: {' '.join(each.symbols)}", png=_png(each.image_bgr))
        for each in kept[::step]
        if each.image_bgr is not None
    ]
    note = f"{len(kept)} kept of {len(rebuilt.grounded.patches)} that were looked at."
    return Section(heading="Patches", note=note, pictures=pictures, is_gallery=True)


def _words(rebuilt: "Rebuilt") -> Section:
    model = rebuilt.grounded.symbols
    pictures = [
        Picture(title=f"what {word!r} means so far", png=draw_symbol(model, word))
        for word in sorted(model.words)
        if model.group_of(word) is not None
    ]
    note = "The features that tell each word best, beside the other words of its group."
    return Section(heading="Words", note=note, pictures=pictures)


def _png(image: ImageArray) -> bytes:
    _, coded = cv2.imencode(".png", np.ascontiguousarray(image))
    return coded.tobytes()
