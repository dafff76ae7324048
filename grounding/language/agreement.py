"""How far two EDS of one sentence agree, on triples (elementary dependency match).

Source:
    Dridan and Oepen 2011, "Parser evaluation using elementary dependency matching": a node is
    (span, predicate), an edge (span, role, span); properties are left out.
"""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from delphin.eds import EDS

Triple = tuple[object, str, object]


@dataclass(frozen=True, slots=True, kw_only=True)
class Agreement:
    """Counts of triples over any number of sentences."""

    common: int
    found: int
    wanted: int

    @property
    def precision(self) -> float:
        """The share of what was found that was wanted."""
        return self.common / self.found if self.found else 0.0

    @property
    def recall(self) -> float:
        """The share of what was wanted that was found."""
        return self.common / self.wanted if self.wanted else 0.0


def triples(eds: EDS) -> Counter[Triple]:
    """Return the predicates and argument edges of an EDS."""
    span = {node.id: (node.cfrom, node.cto) for node in eds.nodes}
    names: Iterable[Triple] = [(span[n.id], "predicate", n.predicate) for n in eds.nodes]
    edges: Iterable[Triple] = [
        (span[source], role, span[target]) for source, role, target in eds.edges if target in span
    ]
    return Counter([*names, *edges])


def agreement(pairs: Iterable[tuple[EDS | None, EDS]]) -> Agreement:
    """Return how far what was found agrees with what was wanted, sentence by sentence.

    Args:
        pairs: (found, wanted) of each sentence; None where nothing was found.
    """
    common = found = wanted = 0
    for got, want in pairs:
        ours = Counter() if got is None else triples(got)
        theirs = triples(want)
        common += sum((ours & theirs).values())
        found += sum(ours.values())
        wanted += sum(theirs.values())
    return Agreement(common=common, found=found, wanted=wanted)
