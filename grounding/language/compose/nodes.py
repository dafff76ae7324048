"""The nodes of one EDS while it is composed."""

from collections.abc import Mapping
from typing import Final

from delphin.eds import EDS, Node
from delphin.lnk import Lnk

Span = tuple[int, int]

UNTENSED: Final = {
    "SF": "prop", "TENSE": "untensed", "MOOD": "indicative", "PROG": "-", "PERF": "-",
}  # fmt: skip


class Nodes:
    """Collects nodes; each method adds one and returns its id."""

    def __init__(self) -> None:
        self._nodes: dict[str, Node] = {}

    def event(
        self, label: str, *, at: Span, edges: Mapping[str, str],
        properties: Mapping[str, str] | None = None, carg: str | None = None,
    ) -> str:  # fmt: skip
        """Add what is done or holds, by default without tense."""
        known = UNTENSED if properties is None else properties
        return self._add("e", label, at=at, edges=edges, properties=known, carg=carg)

    def thing(
        self, label: str, *, at: Span, properties: Mapping[str, str],
        edges: Mapping[str, str] | None = None, carg: str | None = None,
    ) -> str:  # fmt: skip
        """Add what is spoken of."""
        return self._add("x", label, at=at, edges=edges or {}, properties=properties, carg=carg)

    def quantifier(self, label: str, *, at: Span, of: str) -> None:
        """Add the quantifier that binds a thing."""
        self._add("_", label, at=at, edges={"BV": of}, properties={}, carg=None)

    def connect(self, node_id: str, *, edges: Mapping[str, str]) -> None:
        """Add edges to a node."""
        self._nodes[node_id].edges.update(edges)

    def span_of(self, node_id: str) -> Span:
        """Return where a node stands."""
        return int(self._nodes[node_id].cfrom), int(self._nodes[node_id].cto)

    def is_pronoun(self, node_id: str) -> bool:
        """Whether a node is a pronoun."""
        return str(self._nodes[node_id].predicate) == "pron"

    def finished(self, *, top: str) -> EDS:
        """Return the EDS with the nodes in the order that PyDelphin gives them, by their spans."""
        ordered = sorted(self._nodes.values(), key=lambda node: (node.cfrom, -node.cto))
        return EDS(top=top, nodes=ordered)

    def _add(
        self, kind: str, label: str, *, at: Span, edges: Mapping[str, str],
        properties: Mapping[str, str], carg: str | None,
    ) -> str:  # fmt: skip
        node_id = f"{kind}{len(self._nodes) + 2}"
        self._nodes[node_id] = Node(
            node_id, label, type=None if kind == "_" else kind, edges=dict(edges),
            properties=dict(properties), carg=carg, lnk=Lnk.charspan(*at),
        )  # fmt: skip
        return node_id
