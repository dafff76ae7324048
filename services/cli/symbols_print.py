"""What the commands under `gazemap symbols` print alike."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from grounding.symbols.listing import ListedPatch
    from grounding.symbols.measure import MeasuredPatch
    from grounding.symbols.model import SymbolModel


def print_groups(model: "SymbolModel") -> None:
    """Print one line for each concept group."""
    for group in model.groups:
        words = (
            f"{word} ({model.words[word].kept} kept, {model.words[word].dropped} dropped)"
            for word in group.words
        )
        print(f"{group.name}{'' if group.is_sure else ' (unsure)'}: {', '.join(words)}")
    for person, lexicon in sorted(model.lexicons.items()):
        names = ", ".join(f"{own} = {word}" for own, word in sorted(lexicon.items()))
        print(f"{person or 'everyone'} says: {names}")


def measured(
    listed: "list[ListedPatch]", *, embedding: Path | None = None, tell_empty: bool = True
) -> "Iterator[MeasuredPatch]":
    """Yield the patches with their features, with a bar and a line on each that is unusual.

    Args:
        listed: the patches.
        embedding: an ONNX file of the user's, or None.
        tell_empty: whether a patch without an object gets a line.
    """
    from grounding.features.background import NoObject

    for patch in measured_quietly(listed, embedding=embedding):
        if patch.note and (tell_empty or not isinstance(patch.features, NoObject)):
            tell(patch.note)
        yield patch


def measured_quietly(
    listed: "list[ListedPatch]", *, embedding: Path | None = None
) -> "Iterator[MeasuredPatch]":
    """Yield the patches with their features, with a bar on a terminal."""
    from rich.console import Console
    from rich.progress import track

    from grounding.features.embedding import Embedding
    from grounding.symbols.measure import measure

    console = Console(stderr=True)
    off = not console.is_terminal
    bar = track(listed, "patches", console=console, disable=off, transient=True)
    network = None if embedding is None else Embedding(embedding)
    yield from measure(bar, embedding=network)


def tell(*notes: str) -> None:
    """Print notes on one thing as one line of standard error."""
    click.echo(" ".join("; ".join(note for note in notes if note).split()), err=True)
