"""`gazemap symbols`: learn what words mean from patches, and say which words a patch bears."""

import csv
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from grounding.symbols.listing import ListedPatch
    from grounding.symbols.measure import MeasuredPatch

_FILE = click.Path(path_type=Path, dir_okay=False)


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
def fit(labels: Path, out: Path, mode: str, unknown_rate: float | None) -> None:
    """Learn the words of LABELS (image,symbols[,segment][,mm_per_px][,weight])."""
    from grounding.symbols.document import to_json
    from grounding.symbols.learn import fit_symbols
    from grounding.symbols.listing import read_labels
    from grounding.symbols.measure import labelled
    from grounding.symbols.records import Mode, RobustConfig, SymbolConfig

    robust = RobustConfig() if unknown_rate is None else RobustConfig(unknown_rate=unknown_rate)
    config = SymbolConfig(mode=Mode(mode), robust=robust)
    patches = labelled(_measured(read_labels(labels), quiet_about_empty=True))
    model = fit_symbols(patches, config)
    _write(out, to_json(model))
    for group in model.groups:
        words = (
            f"{w} ({model.words[w].kept} kept, {model.words[w].dropped} dropped)"
            for w in group.words
        )
        print(f"{group.name}{'' if group.is_sure else ' (unsure)'}: {', '.join(words)}")


@command.command()
@click.argument("model", type=_FILE)
@click.argument("images", nargs=-1, type=_FILE)
@click.option("--list", "listing", type=_FILE, help="A csv file with image[,mm_per_px].")
@click.option("--out", type=_FILE, help="Where to write the rows; standard output without it.")
def classify(model: Path, images: tuple[Path, ...], listing: Path | None, out: Path | None) -> None:
    """Say, for each image and concept group, which word of MODEL it bears."""
    from grounding.symbols.listing import ListedPatch, read_list

    listed = [ListedPatch(name=str(path), path=path) for path in images]
    listed += read_list(listing) if listing else []
    if not listed:
        raise click.UsageError("give images, or a list of them with --list")
    rows, readable = _rows(model, listed)
    _write_rows(rows, out)
    if not readable:
        sys.exit(1)


def _rows(model: Path, listed: "list[ListedPatch]") -> tuple[list[tuple[str, ...]], int]:
    """Return the csv rows, and how many images could be read."""
    from grounding.features.registry import PatchFeatures
    from grounding.symbols.classify import Classifier
    from grounding.symbols.store import read_model

    known = read_model(model)
    classifier = Classifier(known)
    rows: list[tuple[str, ...]] = []
    readable = 0
    for patch in _measured(listed):
        readable += patch.features is not None
        if not isinstance(patch.features, PatchFeatures):
            rows += [(patch.listed.name, group.name, "", "", "0") for group in known.groups]
            continue
        rows += [
            (patch.listed.name, each.group, each.symbol, f"{each.score:.6g}", str(int(each.known)))
            for each in classifier.classify(patch.features)
        ]
    return rows, readable


def _measured(
    listed: "list[ListedPatch]", *, quiet_about_empty: bool = False
) -> "Iterator[MeasuredPatch]":
    """Yield the patches with their features, with a bar and a line on each that is unusual."""
    from rich.console import Console
    from rich.progress import track

    from grounding.features.background import NoObject
    from grounding.symbols.measure import measure

    console = Console(stderr=True, soft_wrap=True, highlight=False, markup=False)
    bar = track(listed, "patches", console=console, disable=not console.is_terminal, transient=True)
    for patch in measure(bar):
        if patch.note and not (quiet_about_empty and isinstance(patch.features, NoObject)):
            console.print(" ".join(patch.note.split()))
        yield patch


def _write(path: Path, text: str) -> None:
    from grounding.symbols.store import write_whole

    write_whole(path, text)


def _write_rows(rows: Iterable[tuple[str, ...]], out: Path | None) -> None:
    import io

    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(("image", "group", "symbol", "score", "known"))
    writer.writerows(rows)
    if out is None:
        print(buffer.getvalue(), end="")
    else:
        _write(out, buffer.getvalue())
