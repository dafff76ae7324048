"""What a speaker says without meaning it: fillers, and words that are broken off and said again."""

from typing import Final

from grounding.language.words import Token

_LONGEST_RESTART: Final = 4


def fluent(tokens: list[Token]) -> list[Token]:
    """Return the tokens of a sentence as the speaker meant them."""
    return _without_fillers(_without_restarts(tokens))


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

    A word said twice in a row counts once. Several words do where they end in the open, with a
    word that needs another behind it, and in a pause, if they name anything.
    """
    kept: list[Token] = []
    for token in tokens:
        kept.append(token)
        if _pauses(token):
            continue
        sizes = range(1, min(_LONGEST_RESTART, len(kept) // 2) + 1)
        size = next((n for n in sizes if _is_restart(kept, size=n)), 0)
        if size:
            del kept[_end_before(kept, size=size) - size : -size]
    return kept


def _is_restart(tokens: list[Token], *, size: int) -> bool:
    """Whether the last `size` tokens were said right before."""
    now, end = tokens[-size:], _end_before(tokens, size=size)
    paused = end < len(tokens) - size
    before = tokens[max(0, end - size) : end]
    if [each.text for each in before] != [each.text for each in now]:
        return False
    last = now[-1]
    if size == 1 and not paused:
        return last.known and not last.is_a("cardinals")
    describes = size > 1 and last.adjective and not last.noun
    if paused:
        return _is_open(last) or bool(describes)
    return all(_is_open(each) for each in now)


def _is_open(token: Token) -> bool:
    """Whether a word needs another behind it."""
    return token.is_a("determiners") or token.is_a("prepositions")


def _end_before(tokens: list[Token], *, size: int) -> int:
    """Return the end of what stands before the last `size` tokens and the pauses ahead of them."""
    end = len(tokens) - size
    while end > 0 and _pauses(tokens[end - 1]):
        end -= 1
    return end


def _pauses(token: Token) -> bool:
    return token.is_a("pause") or token.is_a("fillers")
