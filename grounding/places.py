"""A location symbol taken apart: its relation, and the words of what it refers to."""

from dataclasses import dataclass
from typing import Final

# The relation of each preposition; those that mean nothing before they were shown name themselves.
_RELATIONS: Final[dict[str, str]] = {
    "left-of": "left-of",
    "right-of": "right-of",
    "in-front-of": "in-front-of",
    "ahead-of": "in-front-of",
    "behind": "behind",
    "in-back-of": "behind",
    "beyond": "behind",
    "between": "between",
    "in-between": "between",
    "on": "on-top-of",
    "onto": "on-top-of",
    "on-to": "on-top-of",
    "upon": "on-top-of",
    "atop": "on-top-of",
    "on-top-of": "on-top-of",
    "over": "on-top-of",
    "above": "on-top-of",
    "in-middle-of": "on-top-of",
    "on-middle-of": "on-top-of",
    "in-center-of": "on-top-of",
    "in": "in",
    "into": "in",
    "in-to": "in",
    "inside": "in",
    "inside-of": "in",
    "within": "in",
    "near": "near",
    "near-to": "near",
    "nearer-to": "near",
    "next-to": "near",
    "close-to": "near",
    "closer-to": "near",
    "close-by": "near",
    "beside": "near",
    "besides": "near",
    "adjacent-to": "near",
    "against": "near",
    "up-against": "near",
    "along": "near",
    "alongside": "near",
    "around": "near",
    "by": "near",
    "at": "near",
    "with": "near",
    "to": "near",
    "toward": "near",
    "towards": "near",
    "up-to": "near",
    "from": "from",
    "out-of": "from",
    "out-from": "from",
    "off": "from",
    "off-of": "from",
    "under": "under",
    "underneath": "under",
    "below": "under",
    "beneath": "under",
    "away-from": "away-from",
    "far-from": "away-from",
    "across-from": "opposite",
    "opposite": "opposite",
    "opposite-to": "opposite",
    "outside": "outside",
    "outside-of": "outside",
    "parallel-to": "parallel-to",
}
_SIDED: Final = {
    f"{lead}-{side}-{of}": f"{side}-of"
    for lead in ("to", "on", "at")
    for side in ("left", "right")
    for of in ("of", "side-of", "hand-side-of")
}
_FORMS: Final = {tuple(form.split("-")): name for form, name in (_RELATIONS | _SIDED).items()}
_LONGEST: Final = max(len(form) for form in _FORMS)
_LEADS: Final = frozenset({"back", "over", "up", "down"})  # "back on the block": nothing is added
_OWN: Final = "-location"
_AND: Final = "-and-"


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """A location symbol taken apart.

    Attributes:
        relation: its normal form (`left-of`, `on-top-of`, ...), or None for the target's own place
            and for a form that is not known.
        landmarks: the words of each thing it refers to; two for "between" two different things,
            none for an own place.
        described: for each landmark the location that describes it ("the cube on the block"), or
            None.
    """

    relation: str | None
    landmarks: tuple[tuple[str, ...], ...]
    described: tuple[str | None, ...] = ()


def parse_location(symbol: str) -> Place:
    """Take a location symbol apart; a form that is not known has no relation and no landmark."""
    words = tuple(symbol.split("-"))
    relation, rest = _begun(words[1:]) if words[0] in _LEADS else (None, ())
    if relation is None:
        relation, rest = _begun(words)
    if relation is None or symbol.endswith(_OWN):
        return Place(relation=None, landmarks=())
    parts = "-".join(rest).split(_AND) if relation == "between" else ["-".join(rest)]
    cut = [_described(tuple(part.split("-"))) for part in parts]
    return Place(
        relation=relation,
        landmarks=tuple(phrase for phrase, _ in cut),
        described=tuple(location for _, location in cut),
    )


def _begun(words: tuple[str, ...]) -> tuple[str | None, tuple[str, ...]]:
    """Return the relation that words begin with, and the rest; the longest form counts."""
    for count in range(min(_LONGEST, len(words) - 1), 0, -1):
        relation = _FORMS.get(words[:count])
        if relation is not None:
            return relation, words[count:]
    return None, ()


def _described(words: tuple[str, ...]) -> tuple[tuple[str, ...], str | None]:
    """Return what a landmark is called, and the location that describes it, or None."""
    for i in range(1, len(words)):
        if _begun(words[i:])[0] is not None:
            return words[:i], "-".join(words[i:])
    return words, None
