"""The nodes of prepositions and adverbs of place."""

from collections.abc import Mapping
from typing import Final

from grounding.language.compose.nodes import Nodes
from grounding.language.grammar.tree import Word
from grounding.language.lexicon import lexicon

# The ERG takes these apart: an adjective or particle, and a preposition on it.
_SPLIT: Final = {
    "close+to": ("_close_a_to", "_to_p_state"), "far+from": ("_far_a_1", "_from_p_state"),
    "away+from": ("_away_p", "_from_p_state"), "near+to": ("_near_a_to", "_to_p_state"),
    "closer+to": ("_close_a_to", "_to_p_state"), "nearer+to": ("_near_a_to", "_to_p_state"),
}  # fmt: skip
_AT_A_PLACE: Final = frozenset({"there", "here", "inside", "outside"})


def add_preposition(
    nodes: Nodes, word: Word, *, edges: Mapping[str, str], event: bool,
    properties: Mapping[str, str] | None = None,
) -> str:  # fmt: skip
    """Add a preposition between what it describes (ARG1) and its landmark (ARG2).

    Args:
        nodes: where to add it.
        word: the preposition; several words are joined by a plus.
        edges: its arguments.
        event: whether it describes an event.
        properties: its own, where it is the main predicate of a clause.
    """
    if word.lemma in _SPLIT:
        first, second = _SPLIT[word.lemma]
        outer = {"ARG1": edges["ARG1"]}
        at = nodes.event(first, at=word.span, edges=outer, properties=properties)
        nodes.event(second, at=word.span, edges={"ARG1": at, "ARG2": edges["ARG2"]})
        return at
    default = (f"_{word.lemma}_p", f"_{word.lemma}_p_state")
    label = lexicon().prepositions.get(word.lemma, default)[event]
    return nodes.event(label, at=word.span, edges=edges, properties=properties)


def add_place(nodes: Nodes, word: Word, *, of: str) -> str:
    """Add an adverb of place: "there" and "inside" are at a place, "forward" is a way."""
    if word.lemma not in _AT_A_PLACE:
        return nodes.event(f"_{word.lemma}_p", at=word.span, edges={"ARG1": of})
    place = add_unnamed_place(nodes, word)
    label = f"_{word.lemma}_a_1" if word.lemma in ("there", "here") else f"_{word.lemma}_p"
    nodes.event(label, at=word.span, edges={"ARG1": place})
    return nodes.event("loc_nonsp", at=word.span, edges={"ARG1": of, "ARG2": place})


def add_unnamed_place(nodes: Nodes, word: Word) -> str:
    """Add the place that a phrase tells without a noun: "from under the table"."""
    place = nodes.thing("place_n", at=word.span, properties={"PERS": "3", "NUM": "sg"})
    nodes.quantifier("def_implicit_q", at=word.span, of=place)
    return place
