"""An EDS as the traversal sees it: what kind each node is, and edges in both directions."""

import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from functools import lru_cache
from typing import Final

from delphin.eds import EDS, Node

from grounding.language.lexicon import lexicon
from grounding.language.words import unknown_noun

_SURFACE: Final = re.compile(
    r"_(?P<lemma>.+?)(?:/(?P<tag>[a-z]+))?_(?P<pos>[a-z])(?:_(?P<sense>.+))?$"
)
_PLURAL_TAG: Final = "nns"


class Part(StrEnum):
    """What a node is."""

    VERB = "v"
    NOUN = "n"
    ADJECTIVE = "a"
    PREPOSITION = "p"
    CONJUNCTION = "c"
    QUANTIFIER = "q"
    OTHER = "x"


_PARTS: Final = {part.value: part for part in Part}
_TAGS: Final = {"n": Part.NOUN, "j": Part.ADJECTIVE, "v": Part.VERB, "i": Part.PREPOSITION}
_ABSTRACT: Final = {
    "pron": Part.NOUN, "generic_entity": Part.NOUN, "part_of": Part.NOUN, "place_n": Part.NOUN,
    "named": Part.NOUN, "card": Part.OTHER, "loc_nonsp": Part.PREPOSITION,
    "implicit_conj": Part.CONJUNCTION, "nominalization": Part.NOUN, "thing": Part.NOUN,
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Predicate:
    """A predicate's name taken apart.

    Attributes:
        lemma: the lemma; several words are joined by a plus; "" for abstract predicates.
        part: what it is.
        sense: the rest of the name.
        unknown: whether the grammar did not know the word.
    """

    lemma: str
    part: Part
    sense: str
    unknown: bool


@lru_cache(maxsize=4096)
def predicate_of(label: str) -> Predicate:
    """Take a predicate's name apart."""
    match = _SURFACE.match(label)
    if match is None:
        part = Part.QUANTIFIER if label.endswith("_q") else _ABSTRACT.get(label, Part.OTHER)
        return Predicate(lemma="", part=part, sense="", unknown=False)
    lemma, tag, pos = match["lemma"], match["tag"], match["pos"]
    if tag:
        known = lexicon()
        part = _TAGS.get(tag[0], Part.OTHER)
        if tag == _PLURAL_TAG and lemma not in known.nouns:
            lemma = unknown_noun(lemma)[0]
        return Predicate(lemma=lemma, part=part, sense="", unknown=True)
    part, sense = _PARTS.get(pos, Part.OTHER), match["sense"] or ""
    unknown = sense == "unknown"
    return Predicate(lemma=lemma, part=part, sense="" if unknown else sense, unknown=unknown)


class Graph:
    """The nodes of an EDS with the edges into each."""

    def __init__(self, eds: EDS, *, sentence: str) -> None:
        self.top = eds.top
        self.sentence = sentence
        self._nodes = {node.id: node for node in eds.nodes}
        self._into: dict[str, list[tuple[str, str]]] = defaultdict(list)
        self._quantifiers: dict[str, str] = {}
        for node in eds.nodes:
            for role, target in node.edges.items():
                if role == "BV":
                    self._quantifiers[target] = node.predicate
                else:
                    self._into[target].append((role, node.id))
        self._ends = sorted(
            (node.cfrom, node.cto) for node in eds.nodes
            if node.predicate.startswith("_") or node.predicate in ("card", "ord", "generic_entity")
            or node.properties.get("PT") == "std"
        )  # fmt: skip

    def __contains__(self, node_id: object) -> bool:
        return node_id in self._nodes

    def node(self, node_id: str) -> Node:
        """Return a node."""
        return self._nodes[node_id]

    def label(self, node_id: str) -> str:
        """Return a node's predicate."""
        return str(self._nodes[node_id].predicate)

    def predicate(self, node_id: str) -> Predicate:
        """Return a node's predicate, taken apart."""
        return predicate_of(self._nodes[node_id].predicate)

    def part(self, node_id: str) -> Part:
        """Return what a node is."""
        return self.predicate(node_id).part

    def argument(self, node_id: str, role: str) -> str | None:
        """Return what a node has in a role; None for nothing or what the graph lacks."""
        target = self._nodes[node_id].edges.get(role)
        return target if target in self._nodes else None

    def arguments(self, node_id: str) -> list[str]:
        """Return what a node has in ARG1, ARG2, ARG3 and the like, in that order."""
        edges = self._nodes[node_id].edges
        roles = sorted(role for role in edges if role != "BV")
        return [edges[role] for role in roles if edges[role] in self._nodes]

    def into(self, node_id: str, *, role: str = "ARG1") -> Iterator[str]:
        """Yield the nodes that have this one in a role, in the order of their spans."""
        found = [source for at, source in self._into[node_id] if at == role]
        yield from sorted(found, key=lambda source: (self._nodes[source].cfrom, source))

    def parents(self, node_id: str) -> list[str]:
        """Return all nodes with an edge to this one."""
        return [source for _, source in self._into[node_id]]

    def quantifier(self, node_id: str) -> str:
        """Return the quantifier that binds a node, or ""."""
        return self._quantifiers.get(node_id, "")

    def start(self, node_id: str) -> int:
        """Return where a node starts in the sentence."""
        return int(self._nodes[node_id].cfrom)

    def is_plural(self, node_id: str) -> bool:
        """Whether a node is in the plural."""
        return bool(self._nodes[node_id].properties.get("NUM") == "pl")

    def words_before(self, node_id: str) -> str:
        """Return the text right before a node that no other node covers."""
        start = self.start(node_id)
        end = max((to for begin, to in self._ends if to <= start and begin < start), default=0)
        return self.sentence[end:start]
