"""What a speaker says without meaning it: fillers, and words that are broken off and said again."""

from typing import Final

from grounding.language.words import Token

_LONGEST_RESTART: Final = 4


def fluent(tokens: list[Token]) -> list[Token]:
    """Return the tokens of a sentence as the speaker meant them."""
    return _without_restarts(_without_fillers(tokens))


def _without_fillers(tokens: list[Token]) -> list[Token]:
    """Leave out "uh" with the pauses around it."""
    kept: list[Token] = []
    skips = False
    for token in tokens:
        if token.is_a("fillers"):
            skips = True
            while kept and kept[-1].is_a("pause"):
                kept.pop()
        elif not (skips and token.is_a("pause")):
            kept.append(token)
            skips = False
    return kept


def _without_restarts(tokens: list[Token]) -> list[Token]:
    """Leave out what is broken off: "put the, put the cube on the the tray".

    A word said twice in a row counts once. Several words do where the first time ends in a pause
    and in the open, with a word that needs another behind it.
    """
    kept: list[Token] = []
    for token in tokens:
        kept.append(token)
        if token.is_a("pause"):
            continue
        sizes = range(1, min(_LONGEST_RESTART, len(kept) // 2) + 1)
        size = next((n for n in sizes if _is_restart(kept, size=n)), 0)
        if size:
            paused = kept[-size - 1].is_a("pause")
            del kept[-2 * size - paused : -size]
    return kept


def _is_restart(tokens: list[Token], *, size: int) -> bool:
    """Whether the last `size` tokens were said right before."""
    now = tokens[-size:]
    paused = len(tokens) > size and tokens[-size - 1].is_a("pause")
    before = tokens[-2 * size - paused : -size - paused]
    if [each.text for each in before] != [each.text for each in now]:
        return False
    needs_more = now[-1].is_a("determiners") or now[-1].is_a("prepositions")
    if size == 1 and not paused:
        return now[-1].known and not now[-1].is_a("cardinals")
    return paused and needs_more
