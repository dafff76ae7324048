"""report.html from its parts."""

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jinja2

from gazemap.session.atomic import whole_file


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Picture:
    """A PNG with what it shows."""

    title: str
    png: bytes

    @property
    def source(self) -> str:
        """The picture as a data URL: the page needs no other file."""
        return "data:image/png;base64," + base64.b64encode(self.png).decode()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Section:
    """A heading with pictures below it; small ones stand side by side."""

    heading: str
    note: str
    pictures: Sequence[Picture]
    is_gallery: bool = False


def write_page(
    path: Path,
    *,
    summary: Mapping[str, Any],
    plan: Mapping[str, Any],
    sections: Sequence[Section],
) -> None:
    """Write the page, whole or not at all."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["millimetres"] = _millimetres
    text = environment.get_template("page.html.jinja").render(
        summary=summary, plan=plan, sections=sections
    )
    with whole_file(path) as partial:
        partial.write_text(text, encoding="utf-8")


def _millimetres(position: Sequence[float] | None) -> str:
    return "unknown" if position is None else ", ".join(f"{x * 1000:.0f}" for x in position)
