"""`gazemap symbols teach`: answer a question, forget, undo, name a synonym, merge."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from services.cli.symbols_print import measured, print_groups

if TYPE_CHECKING:
    from grounding.symbols.listing import ListedPatch
    from grounding.symbols.model import SymbolModel

_FILE = click.Path(path_type=Path, dir_okay=False)
_IMAGE = click.Path(path_type=Path)  # one that is none gets a line and stops nothing


@click.command()
@click.argument("model", type=_FILE)
@click.argument("word", required=False)
@click.argument("images", nargs=-1, type=_IMAGE)
@click.option("--list", "listing", type=_FILE, help="A csv file with image[,mm_per_px].")
@click.option(
    "--mm-per-px", type=click.FloatRange(min=0, min_open=True), help="Metric scale of the images."
)
@click.option("--embedding", type=_FILE, help="An ONNX image embedding to measure patches with.")
@click.option("--group", help="What a new word describes; `new` for a name of one thing.")
@click.option("--same-as", help="WORD is another name for this word.")
@click.option("--person", default="", help="Whose own word it is; everyone's without it.")
@click.option("--forget", is_flag=True, help="Forget WORD.")
@click.option("--merge", type=_FILE, help="Take over what another model knows.")
@click.option("--undo", is_flag=True, help="Go back to the model before the last change.")
@click.pass_context
def teach(ctx: click.Context, /, model: Path, word: str | None, **_: object) -> None:
    """Change what MODEL knows of WORD; two or three IMAGES make it known from then on."""
    from grounding.symbols.store import read_model, save_model, undo

    options = ctx.params
    if options["undo"]:
        print_groups(undo(model))
        return
    word = "-".join(word.lower().split()) if word else None
    known = read_model(model)
    if options["merge"]:
        from grounding.symbols.lexicon import merged

        known = merged(known, read_model(options["merge"]))
    elif word is None:
        raise click.UsageError("give a WORD, --merge or --undo")
    else:
        known = _changed(known, word, options)
    save_model(model, known)
    print_groups(known)


def _changed(model: "SymbolModel", word: str, options: dict[str, object]) -> "SymbolModel":
    """Return the model with one word forgotten, named alike, or learnt."""
    from grounding.symbols.lexicon import call
    from grounding.symbols.online import forget

    if options["forget"]:
        return forget(model, word)
    if options["same_as"]:
        return call(model, word, str(options["same_as"]), person=str(options["person"]))
    return _learnt(model, word, options)


def _learnt(model: "SymbolModel", word: str, options: dict[str, object]) -> "SymbolModel":
    from grounding.errors import InputError
    from grounding.features.registry import PatchFeatures
    from grounding.symbols.lexicon import understand
    from grounding.symbols.teach import WhichGroup, teach

    network = options["embedding"]
    patches = measured(_listed(options), embedding=network if isinstance(network, Path) else None)
    found = [patch.features for patch in patches]
    group = str(options["group"] or "") or None
    examples = [features for features in found if isinstance(features, PatchFeatures)]
    taught = teach(model, understand(model, word) or word, examples, group=group)
    if isinstance(taught, WhichGroup):
        raise InputError(
            f"the examples do not tell what {word!r} describes",
            where="teach",
            todo=f"add --group with one of: {', '.join(taught.groups)}",
        )
    return taught.model


def _listed(options: dict[str, object]) -> "list[ListedPatch]":
    from grounding.symbols.listing import ListedPatch, read_list

    images, scale, listing = options["images"], options["mm_per_px"], options["listing"]
    listed = []
    if isinstance(images, tuple):
        listed = [
            ListedPatch(
                name=str(path), path=path, mm_per_px=scale if isinstance(scale, float) else None
            )
            for path in images
        ]
    return listed + (read_list(listing) if isinstance(listing, Path) else [])
