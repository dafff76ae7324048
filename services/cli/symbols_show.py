"""`gazemap symbols show`: what a model knows, as a table and as pictures."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from grounding.symbols.model import SymbolModel

_FILE = click.Path(path_type=Path, dir_okay=False)


@click.command()
@click.argument("model", type=_FILE)
@click.argument("words", nargs=-1)
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    help="Where to put a picture of each word.",
)
@click.option("--dropped", is_flag=True, help="List the patches that were dropped, and why.")
@click.option("--lexicon", "person", help="Print a person's own words as JSON; '' for everyone's.")
def show(
    model: Path, words: tuple[str, ...], out: Path | None, *, dropped: bool, person: str | None
) -> None:
    """Show what MODEL knows of WORDS, or of all."""
    from grounding.symbols.lexicon import exported
    from grounding.symbols.store import read_model

    known = read_model(model)
    if person is not None:
        print(exported(known, person=person))
        return
    chosen = words or tuple(sorted(known.words))
    _check(known, chosen, model)
    _print_words(known, chosen)
    if dropped:
        _print_dropped(known, chosen)
    if out is not None:
        _write_pictures(known, chosen, out)


def _check(model: "SymbolModel", words: tuple[str, ...], path: Path) -> None:
    from grounding.errors import InputError

    for word in words:
        if word not in model.words:
            todo = f"name one of: {', '.join(sorted(model.words))}"
            raise InputError(f"no word {word!r}", where=path, todo=todo)


def _print_words(model: "SymbolModel", words: tuple[str, ...]) -> None:
    from rich.console import Console
    from rich.table import Table

    from grounding.symbols.picture import telling_features

    table = Table("word", "group", "kept", "dropped", "told by")
    for word in words:
        group = model.group_of(word)
        if group is None:
            continue
        sure = group.name if group.is_sure else f"{group.name} (unsure)"
        telling = ", ".join(telling_features(model, group, word)[:3])
        counts = (str(model.words[word].kept), str(model.words[word].dropped))
        table.add_row(word, sure, *counts, telling)
    Console().print(table)


def _print_dropped(model: "SymbolModel", words: tuple[str, ...]) -> None:
    print("patch,segment,symbol,reason")
    for each in model.decisions:
        if each.symbol in words and not each.kept:
            print(f"{each.patch},{each.segment},{each.symbol},{each.reason}")


def _write_pictures(model: "SymbolModel", words: tuple[str, ...], out: Path) -> None:
    from grounding.symbols.picture import draw_symbol

    out.mkdir(parents=True, exist_ok=True)
    for word in words:
        path = out / f"{word}.png"
        path.write_bytes(draw_symbol(model, word))
        print(path)
