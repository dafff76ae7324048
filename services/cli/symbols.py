"""`gazemap symbols`: learn what words mean from patches, and say which words a patch bears."""

import csv
import io
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from services.cli.symbols_answer import answer
from services.cli.symbols_print import measured, measured_quietly, print_groups, tell
from services.cli.symbols_reproduce import reproduce
from services.cli.symbols_show import show
from services.cli.symbols_teach import teach

if TYPE_CHECKING:
    from grounding.symbols.listing import ListedPatch

_FILE = click.Path(path_type=Path, dir_okay=False)
_IMAGE = click.Path(path_type=Path)  # one that is none gets a line and stops nothing


@click.group()
def command() -> None:
    """Learn what words mean from patches, and say which words a patch bears."""


@command.command()
@click.argument("labels", type=_FILE)
@click.option("--out", required=True, type=_FILE, help="Where to write the model.")
@click.option("--mode", type=click.Choice(["robust", "paper"]), default="robust", show_default=True)
@click.option(
    "--unknown-rate",
    type=float,
    default=None,
    help="Share of known things that may be called unknown.  [default: 0.001]",
)
@click.option("--embedding", type=_FILE, help="An ONNX image embedding to measure patches with.")
def fit(
    labels: Path, out: Path, mode: str, unknown_rate: float | None, embedding: Path | None
) -> None:
    """Learn the words of LABELS (image,symbols[,segment][,mm_per_px][,weight])."""
    from grounding.errors import InputError
    from grounding.symbols.learn import fit_symbols
    from grounding.symbols.listing import read_labels
    from grounding.symbols.measure import labelled
    from grounding.symbols.records import Mode, RobustConfig, SymbolConfig
    from grounding.symbols.store import save_model

    robust = RobustConfig() if unknown_rate is None else RobustConfig(unknown_rate=unknown_rate)
    config = SymbolConfig(mode=Mode(mode), robust=robust)
    patches = labelled(measured(read_labels(labels), embedding=embedding, tell_empty=False))
    if not patches:
        raise InputError(
            "no patch could be read", where=labels, todo="check that its images are beside it"
        )
    model = fit_symbols(patches, config)
    save_model(out, model)
    print_groups(model)


@command.command()
@click.argument("model", type=_FILE)
@click.argument("images", nargs=-1, type=_IMAGE)
@click.option("--list", "listing", type=_FILE, help="A csv file with image[,mm_per_px].")
@click.option(
    "--mm-per-px", type=click.FloatRange(min=0, min_open=True), help="Metric scale of IMAGES."
)
@click.option("--out", type=_FILE, help="Where to write the rows; standard output without it.")
@click.option("--embedding", type=_FILE, help="An ONNX image embedding to measure patches with.")
def classify(
    model: Path,
    images: tuple[Path, ...],
    listing: Path | None,
    mm_per_px: float | None,
    embedding: Path | None,
    out: Path | None,
) -> None:
    """Say, for each image and concept group, which word of MODEL it bears."""
    from grounding.symbols.listing import ListedPatch, read_list

    listed = [ListedPatch(name=str(path), path=path, mm_per_px=mm_per_px) for path in images]
    listed += read_list(listing) if listing else []
    if not listed:
        raise click.UsageError("give images, or a list of them with --list")
    rows, readable = _rows(model, listed, embedding)
    _write_rows(rows, out)
    if not readable:
        sys.exit(1)


def _rows(
    model: Path, listed: "list[ListedPatch]", embedding: Path | None
) -> tuple[list[tuple[str, ...]], int]:
    """Return the csv rows, and how many images could be read; ask about what is unknown."""
    from grounding.features.registry import PatchFeatures
    from grounding.symbols.classify import Classifier
    from grounding.symbols.store import read_model
    from grounding.symbols.teach import questions

    known = read_model(model)
    classifier = Classifier(known)
    rows: list[tuple[str, ...]] = []
    readable = 0
    for patch in measured_quietly(listed, embedding=embedding):
        readable += patch.features is not None
        if not isinstance(patch.features, PatchFeatures):
            tell(patch.note)
            rows += [(patch.listed.name, group.name, "", "", "0") for group in known.groups]
            continue
        found = classifier.classify(patch.features)
        rows += [
            (patch.listed.name, each.group, each.symbol, f"{each.score:.6g}", str(int(each.known)))
            for each in found
        ]
        asked = [question.text for question in questions(known, found)]
        if asked or patch.note:
            tell(patch.note or f"{patch.listed.path}: {asked.pop(0)}", *asked)
    return rows, readable


def _write_rows(rows: Iterable[tuple[str, ...]], out: Path | None) -> None:
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(("image", "group", "symbol", "score", "known"))
    writer.writerows(rows)
    if out is None:
        print(buffer.getvalue(), end="")
    else:
        from grounding.symbols.store import write_whole

        write_whole(out, buffer.getvalue())


command.add_command(teach)
command.add_command(answer)
command.add_command(show)
command.add_command(reproduce)
