"""Compound nouns: a steak knife is a knife but no steak.

A compound is one symbol with hyphens, its head last: `steak-knife`. Its patches teach the head
too, never the modifier. Compounds of one head form a group of their own; one that was never seen
means what its head means.
"""


def head_of(word: str) -> str | None:
    """Return the head of a compound, or None for a plain word.

    >>> head_of("steak-knife"), head_of("knife")
    ('knife', None)
    """
    modifier, _, head = word.rpartition("-")
    return head if modifier and head else None


def expanded(symbols: tuple[str, ...]) -> tuple[str, ...]:
    """Return symbols with the heads of compounds, each once.

    >>> expanded(("sharp", "steak-knife"))
    ('sharp', 'knife', 'steak-knife')
    """
    with_heads: list[str] = []
    for word in symbols:
        head = head_of(word)
        with_heads.extend([word] if head is None else [head, word])
    return tuple(dict.fromkeys(with_heads))
