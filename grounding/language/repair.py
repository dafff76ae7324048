"""Repairs of what a large grammar is known to misread in instructions, on the EDS itself."""

from collections.abc import Mapping
from typing import Final

from delphin.eds import EDS, Node

from grounding.language.graph import Part, predicate_of
from grounding.language.lexicon import lexicon
from grounding.language.verbs import VerbTable

_SIDEWAYS: Final = {"left": "of", "right": "of", "close": "to", "next": "to"}

Nodes = dict[str, Node]


def repaired(eds: EDS, *, verbs: VerbTable) -> EDS:
    """Return an EDS with known misreadings set right.

    - "between X and Y", read as a conjunction of the target and Y;
    - "the ball left of the block", read as a compound, a left of balls;
    - "lift up the ball" and "hand over the cup", read as a lift up a ball, no sentence;
    - "after taking it", read as a time after a nominalization, where it is a clause of time.
    """
    nodes: Nodes = {node.id: node for node in eds.nodes}
    top = eds.top
    for node in eds.nodes:
        if predicate_of(node.predicate).lemma == "between":
            _give_second_landmark(nodes, between=node)
        elif predicate_of(node.predicate).lemma in lexicon().subordinators:
            _give_clause(nodes, conjunction=node)
        elif node.predicate == "compound" and node.id in nodes:
            _free_from_compound(nodes, compound=node)
        elif node.predicate == "unknown" and node.id in nodes:
            top = _as_command(nodes, fragment=node, verbs=verbs) or top
    return EDS(top=top, nodes=nodes.values())


def _changed(node: Node, *, predicate: str | None = None, edges: Mapping[str, str]) -> Node:
    """Return a copy of a node with another predicate and other edges."""
    return Node(
        node.id, predicate or node.predicate, type=node.type, edges=dict(edges),
        properties=node.properties, carg=node.carg, lnk=node.lnk,
    )  # fmt: skip


def _redirect(nodes: Nodes, *, old: str, new: str) -> None:
    """Let every edge to a node point to another."""
    for node in list(nodes.values()):
        if old in node.edges.values():
            edges = {role: new if to == old else to for role, to in node.edges.items()}
            nodes[node.id] = _changed(node, edges=edges)


def _give_second_landmark(nodes: Nodes, *, between: Node) -> None:
    target, first = between.edges.get("ARG1"), between.edges.get("ARG2")
    if target is None or first not in nodes:
        return
    alone = predicate_of(nodes[first].predicate).part is not Part.CONJUNCTION
    if not alone or nodes[first].properties.get("NUM") == "pl":
        return
    pair = next(
        (
            node for node in nodes.values()
            if node.edges.get("ARG1") == target
            and predicate_of(node.predicate).part is Part.CONJUNCTION
        ), None,
    )  # fmt: skip
    if pair is None:
        return
    _redirect(nodes, old=pair.id, new=target)
    quantifiers = [node for node in nodes.values() if node.edges.get("BV") == target]
    for extra in quantifiers[:1] if len(quantifiers) > 1 else []:
        nodes[extra.id] = _changed(extra, edges={"BV": pair.id})
    nodes[pair.id] = _changed(pair, edges={**pair.edges, "ARG1": first})
    nodes[between.id] = _changed(between, edges={"ARG1": target, "ARG2": pair.id})


def _give_clause(nodes: Nodes, *, conjunction: Node) -> None:
    name = conjunction.edges.get("ARG2")
    act = nodes[name].edges.get("ARG1") if name in nodes else None
    main = conjunction.edges.get("ARG1")
    if name not in nodes or nodes[name].predicate != "nominalization" or act not in nodes:
        return
    for node in list(nodes.values()):
        if node.edges.get("BV") == name:
            del nodes[node.id]
    del nodes[name]
    label = lexicon().subordinators[predicate_of(conjunction.predicate).lemma].predicate
    edges = {"ARG1": str(main), "ARG2": str(act)}
    nodes[conjunction.id] = _changed(conjunction, predicate=label, edges=edges)


def _free_from_compound(nodes: Nodes, *, compound: Node) -> None:
    head, noun = compound.edges.get("ARG1"), compound.edges.get("ARG2")
    if head not in nodes or noun not in nodes:
        return
    word = predicate_of(nodes[head].predicate).lemma
    wanted = _SIDEWAYS.get(word)
    phrase = next(
        (
            node for node in nodes.values()
            if wanted and node.edges.get("ARG1") == head
            and predicate_of(node.predicate).lemma == wanted
        ), None,
    )  # fmt: skip
    if phrase is None:
        return
    for node in list(nodes.values()):
        if node.edges.get("BV") == noun:
            del nodes[node.id]
    edges = {**phrase.edges, "ARG1": noun}
    nodes[phrase.id] = _changed(phrase, predicate=f"_{word}+{wanted}_p", edges=edges)
    for gone in (head, compound.id):
        nodes.pop(gone, None)
    _redirect(nodes, old=head, new=noun)


def _as_command(nodes: Nodes, *, fragment: Node, verbs: VerbTable) -> str | None:
    """Make a command of "a lift up the ball"; return its verb, or None if it is none."""
    noun = str(fragment.edges.get("ARG"))
    if noun not in nodes:
        return None
    lemma = predicate_of(nodes[noun].predicate).lemma
    particle = next(
        (
            node for node in nodes.values()
            if node.edges.get("ARG1") == noun and "ARG2" in node.edges
            and predicate_of(node.predicate).lemma in lexicon().closed["particles"]
        ), None,
    )  # fmt: skip
    if particle is None or verbs.entry(lemma) is None:
        return None
    spoken = predicate_of(particle.predicate).lemma
    head = nodes[noun]
    for node in list(nodes.values()):
        if node.edges.get("BV") == noun:
            del nodes[node.id]
    nodes[noun] = Node(
        noun, f"_{lemma}_v_1", type="e", edges={"ARG2": particle.edges["ARG2"]},
        properties={"SF": "comm"}, lnk=head.lnk,
    )  # fmt: skip
    nodes[particle.id] = _changed(particle, predicate=f"_{spoken}_p_state", edges={"ARG1": noun})
    nodes.pop(fragment.id, None)
    return noun
