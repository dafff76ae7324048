"""The verbs of an EDS that are commanded, or why one is not."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

from grounding.language.drafts import Reason, Refusal, refusal
from grounding.language.graph import Graph, Part
from grounding.language.lexicon import CORRECTION, SideRole, Subordinator, lexicon
from grounding.language.verbs import VerbEntry, VerbTable, teaching_hint

_DENYING: Final = frozenset({"never", "not"})
_ALLOWING: Final = frozenset({"should", "must", "shall", "have", "need", "ought"})
_REQUESTING: Final = frozenset({"can", "could", "will", "would", "may", "might", "shall", "should"})
_FILLERS: Final = frozenset({"go", "come"})
_SPREADING: Final = frozenset({"and", "or", "nor", ""})


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """A verb that is commanded.

    Attributes:
        event: its node.
        verb: its lemma.
        entry: what it does.
        aside: whether it is said in a clause that only tells when.
    """

    event: str
    verb: str
    entry: VerbEntry
    aside: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class _Context:
    """What was said above a verb."""

    denied: bool = False
    modal: str = ""
    asked: bool = False
    ordered: bool = False
    aside: bool = False


def commands(graph: Graph, *, verbs: VerbTable) -> list[Command | Refusal]:
    """Return each verb of the sentence in order, as a command or with why it is none."""
    if graph.top is None or graph.top not in graph:
        return [refusal(Reason.NOT_UNDERSTOOD)]
    finder = _Finder(graph=graph, verbs=verbs, visited=set())
    root = finder.root(graph.top)
    asked = graph.node(root).properties.get("SF") == "ques"
    return list(finder.under(root, context=_Context(asked=asked)))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Finder:
    graph: Graph
    verbs: VerbTable
    visited: set[str]

    def root(self, top: str) -> str:
        """Climb from the top, which may be a first conjunct, to what holds all verbs."""
        seen = {top}
        node_id = top
        while True:
            above = [each for each in self.graph.parents(node_id) if each not in seen]
            parent = next((each for each in above if self._holds(each)), None)
            if parent is None:
                return node_id
            seen.add(parent)
            node_id = parent

    def _holds(self, node_id: str) -> bool:
        graph = self.graph
        if graph.node(node_id).type == "x":
            return False
        predicate = graph.predicate(node_id)
        if graph.part(node_id) is Part.CONJUNCTION or graph.label(node_id) in ("neg", "subord"):
            return True
        if self._subordinator(node_id) is not None:
            return True
        return predicate.lemma in _DENYING or predicate.sense in ("modal", "qmodal")

    def under(self, node_id: str, *, context: _Context) -> Iterator[Command | Refusal]:
        """Yield the commands at and below a node."""
        if node_id in self.visited:
            return
        graph = self.graph
        denials = [] if context.denied else self._denials(node_id)
        self.visited.add(node_id)
        if denials:
            self.visited.update(denials)
            context = replace(context, denied=True)
        if graph.part(node_id) is Part.CONJUNCTION:
            yield from self._row(node_id, context=context)
        elif graph.part(node_id) is Part.VERB:
            yield from self._verb(node_id, context=context)
        elif graph.label(node_id) == "neg" or graph.predicate(node_id).lemma in _DENYING:
            yield from self._below(node_id, context=replace(context, denied=True))
        elif self._subordinator(node_id) is not None:
            yield from self._with_side(node_id, context=context)
        else:
            yield from self._other(node_id, context=context)

    def _denials(self, node_id: str) -> list[str]:
        graph = self.graph
        return [
            each for each in graph.into(node_id)
            if each not in self.visited
            and (graph.label(each) == "neg" or graph.predicate(each).lemma in _DENYING)
        ]  # fmt: skip

    def _row(self, node_id: str, *, context: _Context) -> Iterator[Command | Refusal]:
        """Yield the commands of a conjunction; "do not A and B" denies both."""
        lemma = self.graph.predicate(node_id).lemma
        if lemma == CORRECTION:
            yield from self._corrected(node_id, context=context)
            return
        denied = context.denied
        if lemma == "or" and not denied and not context.asked:
            yield refusal(Reason.CHOICE)
            return
        for argument in self.graph.arguments(node_id):
            first = not denied and bool(self._denials(argument))
            yield from self.under(argument, context=replace(context, denied=denied))
            if first and lemma in _SPREADING and self.graph.part(argument) is Part.VERB:
                denied = True

    def _corrected(self, node_id: str, *, context: _Context) -> Iterator[Command | Refusal]:
        """Yield what is meant by "take it, no, push it"; what was taken back may still be named."""
        arguments = self.graph.arguments(node_id)
        for each in arguments[:-1]:
            for found in self.under(each, context=context):
                yield replace(refusal(Reason.TAKEN_BACK), event=found.event)
        for each in arguments[-1:]:
            yield from self.under(each, context=context)

    def _subordinator(self, node_id: str) -> Subordinator | None:
        """Return what a conjunction of two clauses says; None for any other node."""
        predicate = self.graph.predicate(node_id)
        if predicate.part is not Part.OTHER or len(self.graph.arguments(node_id)) != 2:
            return None
        return lexicon().subordinators.get(predicate.lemma)

    def _with_side(self, node_id: str, *, context: _Context) -> Iterator[Command | Refusal]:
        """Yield what a sentence commands with its subordinate clause, in the order of doing."""
        found = self._subordinator(node_id)
        main, side = self.graph.arguments(node_id)
        ours = self._subject(self._first_of(side)) != "3"
        role = SideRole.CONDITION if found is None else found.role
        if role is SideRole.CONDITION or (role is SideRole.OCCASION and not ours):
            yield refusal(Reason.CONDITION)
            return
        told = list(self.under(main, context=context))
        if role is SideRole.REASON or not any(isinstance(each, Command) for each in told):
            yield from told
            return
        aside = list(self.under(side, context=replace(context, aside=True)))
        yield from (*told, *aside) if role is SideRole.LATER else (*aside, *told)

    def _first_of(self, node_id: str) -> str:
        """Return the first verb or adjective that a conjunction holds."""
        while self.graph.part(node_id) is Part.CONJUNCTION and self.graph.arguments(node_id):
            node_id = self.graph.arguments(node_id)[0]
        return node_id

    def _below(self, node_id: str, *, context: _Context) -> Iterator[Command | Refusal]:
        events = [each for each in self.graph.arguments(node_id) if self._is_event(each)]
        for each in events:
            yield from self.under(self._row_of(each), context=context)
        if not events:
            yield refusal(Reason.NOT_UNDERSTOOD)

    def _row_of(self, node_id: str) -> str:
        """Return the conjunction that starts with a verb, for an edge to it means them all."""
        for parent in self.graph.parents(node_id):
            first = self.graph.arguments(parent)[:1]
            conjoins = self.graph.part(parent) is Part.CONJUNCTION and parent not in self.visited
            if conjoins and first == [node_id]:
                return parent
        return node_id

    def _is_event(self, node_id: str) -> bool:
        return self.graph.node(node_id).type in ("e", "i", None) or (
            self.graph.label(node_id) == "nominalization"
        )

    def _other(self, node_id: str, *, context: _Context) -> Iterator[Command | Refusal]:
        graph = self.graph
        label, predicate = graph.label(node_id), graph.predicate(node_id)
        inner = [each for each in graph.arguments(node_id)[:1] if self._is_event(each)]
        wraps = label in ("subord", "polite", "nominalization", "parg_d", "discourse")
        adverb = predicate.part is Part.ADJECTIVE or predicate.sense == "a"
        if inner and (wraps or adverb):
            yield from self._below(node_id, context=context)
        elif label == "unknown":
            yield refusal(Reason.FRAGMENT)
        elif predicate.part in (Part.PREPOSITION, Part.ADJECTIVE):
            yield refusal(Reason.QUESTION if context.asked else Reason.STATEMENT)
        else:
            yield refusal(Reason.NOT_UNDERSTOOD)

    def _verb(self, node_id: str, *, context: _Context) -> Iterator[Command | Refusal]:
        predicate = self.graph.predicate(node_id)
        particle = self._particle(node_id)
        entry = None if predicate.unknown else self.verbs.entry(predicate.lemma, particle=particle)
        if predicate.unknown and predicate.lemma in self.verbs.entries:
            entry = self.verbs.entry(predicate.lemma, particle=particle)
        below = [each for each in self.graph.arguments(node_id) if self._brings(each)]
        if below and (entry is None or self.graph.argument(node_id, "ARG2") in below):
            yield from self._brought(node_id, below=below, context=context)
        elif predicate.lemma == "be":
            yield refusal(Reason.QUESTION if context.asked else Reason.STATEMENT)
        elif entry is None and predicate.lemma in _FILLERS and self._is_conjoined(node_id):
            yield replace(refusal(Reason.STATEMENT, verb=predicate.lemma), event=node_id)
        else:
            yield self._judged(node_id, entry=entry, particle=particle, context=context)

    def _brings(self, node_id: str) -> bool:
        """Whether a node is a predicate that a verb above it may bring."""
        part = self.graph.part(node_id)
        verbal = self._is_event(node_id) and part in (Part.VERB, Part.CONJUNCTION)
        denial = self.graph.predicate(node_id).lemma in _DENYING
        return verbal or denial or self.graph.label(node_id) == "neg"

    def _is_conjoined(self, node_id: str) -> bool:
        return any(
            self.graph.part(each) is Part.CONJUNCTION for each in self.graph.parents(node_id)
        )

    def _brought(
        self, node_id: str, *, below: list[str], context: _Context
    ) -> Iterator[Command | Refusal]:
        """Yield what is below a verb that brings another: "could", "try", "forget"."""
        lemma = self.graph.predicate(node_id).lemma
        control = lexicon().control
        flips = lemma in control["not_to"] or lemma in control["not_gerund"]
        brings = flips or any(lemma in members for members in control.values())
        if not brings:
            yield refusal(Reason.UNKNOWN_VERB, verb=lemma, message=teaching_hint(lemma))
            return
        inner = replace(
            context, denied=context.denied != flips,
            modal=context.modal or (lemma if lemma in _REQUESTING else ""),
            ordered=context.ordered or lemma in _ALLOWING,
        )  # fmt: skip
        for each in below:
            yield from self.under(self._row_of(each), context=inner)

    def _particle(self, node_id: str) -> str:
        sense = self.graph.predicate(node_id).sense.removeprefix("x-")
        particles = lexicon().closed["particles"]
        entry = self.verbs.entry(self.graph.predicate(node_id).lemma)
        changing = frozenset() if entry is None else entry.not_with
        if sense in particles or sense in changing:
            return sense
        for source in self.graph.into(node_id):
            lemma = self.graph.predicate(source).lemma
            if (lemma in particles or lemma in changing) and self.graph.argument(
                source, "ARG2"
            ) is None:
                return lemma
        return ""

    def _judged(
        self, node_id: str, *, entry: VerbEntry | None, particle: str, context: _Context
    ) -> Command | Refusal:
        lemma = self.graph.predicate(node_id).lemma
        if context.denied:
            return replace(refusal(Reason.NEGATED, verb=lemma), event=node_id)
        person = self._subject(node_id)
        told = context.ordered or context.aside or self._commands(node_id)
        silent = person == "" and not told
        state = entry is None and lemma in lexicon().closed["statives"]
        if context.aside and (state or person == "3"):
            return replace(refusal(Reason.STATEMENT, verb=lemma), event=node_id)
        if person == "3" or silent:
            return refusal(Reason.QUESTION if context.asked else Reason.STATEMENT, verb=lemma)
        if context.asked and not (context.modal and person in ("2", "1pl")):
            return refusal(Reason.QUESTION, verb=lemma)
        if entry is None:
            spoken = (
                lemma if not particle or lemma not in self.verbs.entries else f"{lemma} {particle}"
            )
            return refusal(Reason.UNKNOWN_VERB, verb=lemma, message=teaching_hint(spoken))
        return Command(event=node_id, verb=lemma, entry=entry, aside=context.aside)

    def _commands(self, node_id: str) -> bool:
        return bool(self.graph.node(node_id).properties.get("SF") == "comm")

    def _subject(self, node_id: str) -> str:
        """Return the person of a verb's subject, "1pl" for us, "" for none."""
        subject = self.graph.argument(node_id, "ARG1")
        if subject is None:
            return ""
        if self.graph.label(subject) != "pron":
            return "3"
        properties = self.graph.node(subject).properties
        person = properties.get("PERS", "2")
        return "1pl" if person == "1" and properties.get("NUM") == "pl" else person
