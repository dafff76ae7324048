"""Prepositional phrases of an EDS, found in both directions, as words in spoken order."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

from grounding.language.drafts import Mention, Phrase
from grounding.language.graph import Graph, Part
from grounding.language.lexicon import lexicon
from grounding.language.mentions import ChoiceLeft, lent, mentions, replaced, with_noun_of

_PLACING: Final = frozenset({"put", "place", "set", "lay", "leave", "drop", "stack", "see", "find"})
_CLAUSE_WORDS: Final = frozenset({"that", "which", "who", "is", "are", "was", "were", "that's"})


@dataclass(frozen=True, slots=True, kw_only=True)
class Unit:
    """One preposition with its landmark.

    Attributes:
        start: where it stands in the sentence.
        preposition: its words, joined by hyphens.
        phrase: the words of it and its landmark.
        in_clause: whether it stands in a relative clause.
        loose: whether that clause can do without it: "the cube that you took".
    """

    start: int
    preposition: str
    phrase: Phrase
    in_clause: bool
    loose: bool = False


def units_of(graph: Graph, heads: list[str], *, skipped: frozenset[str]) -> list[Unit]:
    """Return the phrases that hang on verbs and nouns, each with those on its landmark.

    The graph is explored from each head and backtracks where nothing hangs; no node is visited
    twice.

    Args:
        graph: the sentence.
        heads: the nodes that the phrases hang on.
        skipped: nodes that have another use.

    Returns:
        The phrases in spoken order.
    """
    explorer = _Explorer(graph=graph, visited=set(skipped))
    found = [unit for head in heads for unit in explorer.on(head, in_clause=False)]
    return sorted(found, key=lambda unit: unit.start)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Explorer:
    graph: Graph
    visited: set[str]

    def on(self, head: str, *, in_clause: bool, nested: bool = False) -> Iterator[Unit]:
        """Yield the phrases that hang on a node; those on a landmark go where it goes."""
        for source in self.graph.into(head):
            yield from self.at(source, in_clause=in_clause, nested=nested)
        third = self.graph.argument(head, "ARG3")
        if third is not None and self.graph.part(third) is Part.PREPOSITION:
            yield from self.at(third, in_clause=in_clause)
        if self.graph.part(head) is Part.NOUN:
            yield from self._in_relative(head, in_clause=in_clause or not nested)

    def at(self, node_id: str, *, in_clause: bool, nested: bool = False) -> Iterator[Unit]:
        """Yield the phrase at a preposition, or an adjective with one, and those inside it."""
        graph = self.graph
        if node_id in self.visited or graph.label(node_id) in ("compound", "ord"):
            return
        part = graph.part(node_id)
        inner = [each for each in graph.into(node_id) if graph.part(each) is Part.PREPOSITION]
        adjective = part is Part.ADJECTIVE and graph.node(node_id).type != "x"
        denied = any(graph.label(each) == "neg" for each in graph.into(node_id))
        if (part is not Part.PREPOSITION and not (adjective and inner)) or (
            denied and not adjective
        ):
            return
        if graph.predicate(node_id).lemma == "of" and not in_clause:
            return
        self.visited.add(node_id)
        clause = in_clause or (not nested and _opens_clause(graph, node_id))
        yield from self._unit(node_id, inner=inner, in_clause=clause)

    def _unit(self, node_id: str, *, inner: list[str], in_clause: bool) -> Iterator[Unit]:
        graph = self.graph
        lemma = graph.predicate(node_id).lemma
        landmark = graph.argument(node_id, "ARG2")
        if landmark is None and not inner and lemma in lexicon().closed["particles"]:
            return
        words = tuple(lemma.split("+")) if lemma else ()
        parts: list[str | Mention] = [*self._conjunction(node_id), *words]
        later: list[Unit] = []
        for each in inner:
            self.visited.add(each)
            found = list(self._unit(each, inner=[], in_clause=in_clause))
            if landmark is None and found:
                parts.extend(found[0].phrase.parts)
                later.extend(found[1:])
            else:
                later.extend(found)
        if landmark is not None:
            parts.extend(self.landmark(landmark))
            later.extend(self._on_landmark(landmark, in_clause=in_clause))
        if parts:
            yield Unit(start=graph.start(node_id), preposition="-".join(words),
                       phrase=Phrase(parts=tuple(parts)), in_clause=in_clause)  # fmt: skip
        yield from later

    def _conjunction(self, node_id: str) -> list[str]:
        """Return the word that ties a phrase to the one before: "on the tray and next to it"."""
        for parent in self.graph.parents(node_id):
            arguments = self.graph.arguments(parent)
            if self.graph.part(parent) is Part.CONJUNCTION and arguments[-1:] == [node_id]:
                word = self.graph.predicate(parent).lemma
                if word in ("or", "nor"):
                    raise ChoiceLeft
                return [word] if word == "and" else []
        return []

    def landmark(self, x: str) -> list[str | Mention]:
        """Return the words of a landmark: conjuncts with "and", a side with what it is of."""
        graph = self.graph
        if replaced(graph, x) is not None:
            return self._corrected(x)
        if graph.part(x) is Part.CONJUNCTION:
            return self._conjoined(x)
        if graph.label(x) == "place_n":
            return self._place(x)
        parts: list[str | Mention] = []
        for each in mentions(graph, x):
            parts.extend(("and", each) if parts else (each,))
        whole = self._whole(x)
        return [*parts, "of", *self.landmark(whole)] if whole is not None else parts

    def _conjoined(self, x: str) -> list[str | Mention]:
        graph = self.graph
        word = graph.predicate(x).lemma or "and"
        if word in ("or", "nor"):
            raise ChoiceLeft
        found = [(each, self.landmark(each)) for each in graph.arguments(x)]
        sides = [(each, side) for each, side in found if side]
        for (_, side), (_, following) in pairwise(sides):
            if isinstance(side[-1], Mention) and isinstance(following[0], Mention):
                side[-1] = lent([side[-1], following[0]])[0]
        for each, side in sides[:-1]:
            side.extend((*self._said_of(each), word))
        return [part for _, side in sides for part in side]

    def _said_of(self, x: str) -> list[str | Mention]:
        """Return the words that say where a landmark is."""
        units = sorted(self._on_landmark(x, in_clause=False), key=lambda unit: unit.start)
        return [part for unit in units for part in unit.phrase.parts]

    def _corrected(self, x: str) -> list[str | Mention]:
        """Return the words of "the red block, no, the blue one": the last is meant."""
        left, *_, right = self.graph.arguments(x)
        parts = self.landmark(right)
        lenders = mentions(self.graph, left) if self.graph.part(left) is Part.NOUN else []
        if parts and isinstance(parts[0], Mention) and lenders:
            return [with_noun_of(parts[0], lender=lenders[-1]), *parts[1:]]
        return parts

    def _whole(self, x: str) -> str | None:
        """Return what a landmark is a side or part of."""
        graph = self.graph
        own = graph.argument(x, "ARG1")
        if own is not None and graph.part(x) is Part.NOUN and graph.label(x) != "part_of":
            return own
        for source in graph.into(x):
            label = graph.label(source)
            side = graph.predicate(x).lemma in lexicon().closed["directions"]
            if source not in self.visited and (
                label.startswith("_of_p") or (label == "poss" and side)
            ):
                self.visited.add(source)
                owner = graph.argument(source, "ARG2")
                return None if owner is None or graph.label(owner) == "pron" else owner
        return None

    def _place(self, x: str) -> list[str | Mention]:
        """Return the words that tell an unnamed place: "there", "under the table"."""
        parts: list[str | Mention] = []
        for source in self.graph.into(x):
            predicate = self.graph.predicate(source)
            if source in self.visited or predicate.part not in (Part.PREPOSITION, Part.ADJECTIVE):
                continue
            self.visited.add(source)
            if predicate.lemma == "back":
                continue
            parts.extend(predicate.lemma.split("+") if predicate.lemma else ())
            landmark = self.graph.argument(source, "ARG2")
            if landmark is not None and predicate.lemma:
                parts.extend(self.landmark(landmark))
        return parts

    def _on_landmark(self, landmark: str, *, in_clause: bool) -> Iterator[Unit]:
        for each in self._leaves(landmark):
            yield from self.on(each, in_clause=in_clause, nested=True)

    def _leaves(self, x: str) -> list[str]:
        """Return the nouns of a landmark: its conjuncts, and what a side is of."""
        graph = self.graph
        if graph.part(x) is Part.CONJUNCTION:
            return [x, *(leaf for each in graph.arguments(x) for leaf in self._leaves(each))]
        wholes = [graph.argument(x, "ARG1")] if graph.part(x) is Part.NOUN else []
        parts = [each for each in graph.into(x) if graph.label(each).startswith("_of_p")]
        wholes.extend(graph.argument(each, "ARG2") for each in parts)
        return [x, *(leaf for whole in wholes if whole for leaf in self._leaves(whole))]

    def _in_relative(self, x: str, *, in_clause: bool) -> Iterator[Unit]:
        """Yield the phrases of a clause that describes a noun: "the cube lying on the table"."""
        graph = self.graph
        clauses = [*graph.into(x), *graph.into(x, role="ARG2")]
        for verb in clauses:
            if graph.part(verb) is Part.VERB and verb not in self.visited:
                self.visited.add(verb)
                yield from self._possessed(verb, of=x, in_clause=in_clause)
                subject = graph.argument(verb, "ARG1")
                loose = subject not in (None, x) and graph.predicate(verb).lemma not in _PLACING
                for unit in self.on(verb, in_clause=in_clause, nested=not in_clause):
                    yield replace(unit, loose=loose)

    def _possessed(self, verb: str, *, of: str, in_clause: bool) -> Iterator[Unit]:
        """Yield "with a red lid" for "that has a red lid"."""
        graph = self.graph
        owned = graph.argument(verb, "ARG2")
        owns = owned is not None and owned != of and graph.quantifier(owned) != "_no_q"
        if graph.predicate(verb).lemma == "have" and owns:
            parts = ("with", *self.landmark(str(owned)))
            yield Unit(
                start=graph.start(verb), preposition="with", phrase=Phrase(parts=parts),
                in_clause=in_clause,
            )  # fmt: skip


def _opens_clause(graph: Graph, node_id: str) -> bool:
    """Whether words of a relative clause that have no node ("that is") stand before a phrase."""
    before = graph.words_before(node_id).lower().replace("'s", " is").split()
    return bool(before) and not _CLAUSE_WORDS.isdisjoint(before)
