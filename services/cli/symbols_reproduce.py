"""`gazemap symbols reproduce`: the paper's experiment, beside the figures it published."""

from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from grounding.symbols.records import Mode
    from grounding.symbols.reproduce import Table as Confusion


@click.command()
@click.option("--seed", type=int, default=0, show_default=True)
@click.option("--patches", type=click.IntRange(min=50), default=2000, show_default=True)
def reproduce(seed: int, patches: int) -> None:
    """Repeat the paper's experiment on simulated patches, in both modes."""
    import numpy as np
    from rich.console import Console
    from rich.progress import track

    from grounding.symbols.learn import fit_symbols
    from grounding.symbols.records import Mode, SymbolConfig
    from grounding.symbols.reproduce import confusion, objects_to_classify, training_patches

    rng = np.random.default_rng(seed)
    console = Console(stderr=True)
    drawn = training_patches(rng, count=patches)
    training = list(
        track(drawn, "drawing patches", patches, console=console, disable=not console.is_terminal)
    )
    objects = objects_to_classify(rng)
    tables = {
        mode: confusion(fit_symbols(training, SymbolConfig(mode=mode)), objects)
        for mode in (Mode.PAPER, Mode.ROBUST)
    }
    _print_figures(tables)
    for concept in ("colour", "shape"):
        for mode, table in tables.items():
            _print_confusion(f"{concept}, {mode} mode", table[concept])


def _print_figures(tables: "dict[Mode, dict[str, Confusion]]") -> None:
    from rich.console import Console
    from rich.table import Table

    from grounding.symbols.reproduce import PUBLISHED

    table = Table("figure", "published", *(f"{mode} mode" for mode in tables))
    for concept, published in PUBLISHED.items():
        for what, known, figures in zip(
            ("all", "known", "unknown"), (None, True, False), published, strict=True
        ):
            ours = [each[concept].right(known=known) for each in tables.values()]
            cells = [f"{right}/{of} = {right / of:.2f}" for right, of in (figures, *ours)]
            table.add_row(f"{concept}, {what}", *cells)
    Console().print(table)


def _print_confusion(title: str, confusion: "Confusion") -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table("true \\ said", *confusion.words, title=title)
    for true in confusion.words:
        counts = (str(confusion.counts.get((true, said), 0)) for said in confusion.words)
        table.add_row(true, *counts)
    Console().print(table)
