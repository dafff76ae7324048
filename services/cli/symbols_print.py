"""What the commands under `gazemap symbols` print alike."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

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
