"""A first reading of narration: verb, object and location phrase by their order alone."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

_ACTIONS: Final = {
    **dict.fromkeys(("pick", "take", "grab", "get", "lift", "grasp"), "pick"),
    **dict.fromkeys(("put", "place", "set", "lay", "drop", "position", "stack"), "place"),
    **dict.fromkeys(("move", "slide", "shift", "bring"), "move"),
    **dict.fromkeys(("turn", "rotate", "flip"), "rotate"),
    **{verb: verb for verb in ("push", "pull", "open", "close", "pour", "give", "point")},
}
_SKIPPED: Final = frozenset(
    ["now", "then", "next", "first", "i", "you", "please", "and", "finally", "we", "the", "a", "an"]
)
_PREPOSITIONS: Final = frozenset(
    [
        "on",
        "in",
        "to",
        "into",
        "onto",
        "next",
        "behind",
        "beside",
        "between",
        "near",
        "under",
        "from",
        "at",
        "inside",
        "left",
        "right",
    ]
)
_PARTICLES: Final = frozenset({"up", "down"})


@dataclass(frozen=True, slots=True, kw_only=True)
class Phrase:
    """One verb with the words of its object and of its location."""

    action: str
    target: tuple[str, ...]
    location: tuple[str, ...]


def phrases(text: str) -> Iterator[Phrase]:
    """Yield the phrases of a text in the order spoken."""
    for clause in re.split(
        r"[.;!?]|,? and then |, | and (?=put|place|take|move|set)", text.lower()
    ):
        words = [word for word in re.findall(r"[a-z]+", clause) if word not in _SKIPPED]
        if words and words[0] in _ACTIONS:
            rest = [word for word in words[1:] if word not in _PARTICLES]
            at = next((i for i, word in enumerate(rest) if word in _PREPOSITIONS), len(rest))
            target, location = tuple(rest[:at]), tuple(rest[at:])
            yield Phrase(action=_ACTIONS[words[0]], target=target, location=location)
