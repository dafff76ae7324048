"""The traversal: from an EDS, whoever made it, to drafts of instructions.

After the paper: nodes that are no verb, adjective, preposition or noun say nothing; the verb is
the top or below it; the noun tied to it with its adjectives is the target; prepositions tied to
either, in both directions, are followed for the location. Which phrase is the location is settled
by the frame of the verb, not by where the parse happened to hang it.
"""

from dataclasses import dataclass, replace
from typing import Final

from delphin.eds import EDS

from grounding.language.commands import Command, commands
from grounding.language.drafts import Draft, Mention, Phrase, Reason, Reference, Refusal, refusal
from grounding.language.graph import Graph, Part
from grounding.language.lexicon import lexicon
from grounding.language.mentions import ChoiceLeft, mentions
from grounding.language.phrases import Unit, units_of
from grounding.language.repair import repaired
from grounding.language.verbs import Frame, VerbTable

_SOURCES: Final = frozenset({"from", "out-of", "off", "off-of", "out", "out-from"})
_NONE: Final = frozenset({"_no_q", "_none_q", "_neither_q"})
_SHOWING: Final = frozenset({"at", "to", "toward", "towards"})


def traverse(eds: EDS, *, sentence: str, verbs: VerbTable) -> list[Draft] | Refusal:
    """Return what a reading commands, in order, or why it commands nothing.

    A negated command or a statement beside a command is left out; anything else that cannot be
    carried out refuses the whole sentence, for half a plan is a guess.
    """
    graph = Graph(repaired(eds, verbs=verbs), sentence=sentence)
    found = commands(graph, verbs=verbs)
    events = frozenset(each.event for each in found if isinstance(each, Command))
    drafts: list[Draft] = []
    left_out: list[Refusal] = []
    for each in found:
        result = each if isinstance(each, Refusal) else _draft(graph, each, events=events)
        if isinstance(each, Command) and drafts and _lacks_object(result):
            result = _elliptic(graph, each, after=drafts[-1]) or result
        if isinstance(result, Draft):
            drafts.append(_told_beside(graph, result, left_out=left_out))
        elif isinstance(each, Command) and each.aside and _lacks_object(result):
            continue
        elif result.is_silent:
            left_out.append(result)
        else:
            return result
    return drafts or next(iter(left_out), refusal(Reason.NOT_UNDERSTOOD))


def _told_beside(graph: Graph, draft: Draft, *, left_out: list[Refusal]) -> Draft:
    """Return a draft that knows what was named before by what commands nothing.

    "It" never stands for the object of a denied verb, unless that verb is said again: "don't put
    the cup on the table, put it on the tray".
    """
    background: tuple[Mention, ...] = ()
    held: tuple[Mention, ...] = ()
    for each in left_out:
        named = _named(graph, each)
        background += named
        held += named if each.reason is not Reason.NEGATED or each.verb == draft.verb else ()
    return replace(draft, background=background, held=held)


def _named(graph: Graph, denied: Refusal) -> tuple[Mention, ...]:
    """Return what a denied command named, and where somebody is to go.

    "Don't take the red cube, take the blue one"; "go to the red cube and take it".
    """
    event = denied.event
    if not event:
        return ()
    ways = [each for each in graph.into(event) if graph.part(each) is Part.PREPOSITION]
    named = [graph.argument(each, "ARG2") for each in (event, *ways)]
    wholes = [graph.argument(each, "ARG1") for each in named if each and not _is_act(graph, each)]
    try:
        return tuple(
            one for each in (*named, *wholes) if each and not _is_act(graph, each)
            for one in mentions(graph, each)
        )  # fmt: skip
    except ChoiceLeft:
        return ()


def _is_act(graph: Graph, node_id: str) -> bool:
    return graph.part(node_id) in (Part.VERB, Part.PREPOSITION, Part.ADJECTIVE)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Object:
    """What a verb acts on, and nodes that were used to find it."""

    node: str
    used: frozenset[str]


def _lacks_object(result: Draft | Refusal) -> bool:
    return isinstance(result, Refusal) and result.reason is Reason.NO_OBJECT


def _elliptic(graph: Graph, command: Command, *, after: Draft) -> Draft | None:
    """Return the draft of "and put on the table", whose object was said with the verb before."""
    units = units_of(graph, [command.event], skipped=frozenset())
    location, _ = _split(units, frame=command.entry.frame, front=graph.start(command.event))
    if not location:
        return None
    plural = len(after.targets) > 1 or after.targets[0].plural
    same = Mention(words=(), reference=Reference.PRONOUN, plural=plural, text=command.verb)
    return Draft(
        action=command.entry.action, verb=command.verb, targets=(same,), location=tuple(location),
        relation=(), start=graph.start(command.event),
    )  # fmt: skip


def _draft(graph: Graph, command: Command, *, events: frozenset[str]) -> Draft | Refusal:
    target = _object(graph, command)
    missing = refusal(
        Reason.NO_OBJECT, verb=command.verb,
        message=f'the verb "{command.verb}" has no object: say what to {command.verb}',
    )  # fmt: skip
    if target is None:
        return missing
    try:
        return _complete(graph, command, target=target, events=events) or missing
    except ChoiceLeft:
        return refusal(Reason.CHOICE)


def _complete(
    graph: Graph, command: Command, *, target: "_Object", events: frozenset[str]
) -> Draft | Refusal | None:
    if graph.quantifier(target.node) in _NONE:
        return refusal(Reason.NEGATED, verb=command.verb)
    targets = mentions(graph, target.node)
    nameless = any(not one.words and one.reference is Reference.NAMED for one in targets)
    persons = any(one.words in (("me",), ("you",), ("us",)) for one in targets)
    if not targets or nameless or persons:
        return None
    units = units_of(
        graph, [command.event, *_nouns(graph, target.node)], skipped=events | target.used
    )
    front = graph.start(command.event)
    if command.entry.frame is Frame.SHOW:
        units = [unit for unit in units if unit.preposition != "at" or unit.in_clause]
    location, relation = _split(units, frame=command.entry.frame, front=front)
    location += _recipient(graph, command, target=target.node)
    return Draft(
        action=command.entry.action, verb=command.verb, targets=tuple(targets),
        location=tuple(location), relation=tuple(relation), start=front,
    )  # fmt: skip


def _object(graph: Graph, command: Command) -> _Object | None:
    target = graph.argument(command.event, "ARG2")
    shows = command.entry.frame is Frame.SHOW
    phrases = [each for each in graph.into(command.event) if _shows(graph, each)]
    pointing = phrases if shows else []
    if target is None and pointing:
        target = graph.argument(pointing[0], "ARG2")
    if target is None or graph.part(target) is Part.VERB or graph.part(target) is Part.PREPOSITION:
        return None
    return _Object(node=target, used=frozenset(pointing))


def _shows(graph: Graph, phrase: str) -> bool:
    """Whether a phrase names what is pointed at; "to the left" is only a way."""
    x = graph.argument(phrase, "ARG2")
    if graph.predicate(phrase).lemma not in _SHOWING or x is None:
        return False
    sides = lexicon().closed["places"] & lexicon().closed["directions"]
    return graph.predicate(x).lemma not in sides or graph.argument(x, "ARG1") is not None


def _nouns(graph: Graph, x: str) -> list[str]:
    """Return a noun node with its conjuncts and the whole it is part of."""
    below = graph.arguments(x) if graph.part(x) is Part.CONJUNCTION else []
    whole = graph.argument(x, "ARG1") if graph.label(x) == "part_of" else None
    return [x, *(each for one in below for each in _nouns(graph, one)), *([whole] if whole else [])]


def _split(units: list[Unit], *, frame: Frame, front: int) -> tuple[list[Phrase], list[Phrase]]:
    """Return the phrases of the location and those that describe the target."""
    behind = [unit for unit in units if unit.start >= front]
    fronted = [unit for unit in units if unit.start < front and not (behind and _is_here(unit))]
    outside = [unit for unit in behind if not unit.in_clause]
    inside = [unit for unit in behind if unit.in_clause]
    if frame is Frame.TAKE:
        at = _first_source(fronted)
        if at < len(fronted):
            return _phrases(fronted[at:]), _phrases([*fronted[:at], *behind])
        at = _first_source(outside)
        return _phrases(outside[at:]), _phrases([*fronted, *inside, *outside[:at]])
    if not fronted and not outside and inside and inside[-1].loose:
        outside, inside = inside[-1:], inside[:-1]
    if fronted and not (_first_source(fronted) == 0 and outside):
        return _phrases(fronted), _phrases(behind)
    if len(outside) > 1 and outside[0].preposition == "with":
        return _phrases([*fronted, *outside[1:]]), _phrases([outside[0], *inside])
    return _phrases([*fronted, *outside]), _phrases(inside)


def _is_here(unit: Unit) -> bool:
    """Whether a phrase is the "here" of "here I put it in the box", which says no place."""
    return unit.phrase.parts == ("here",)


def _first_source(units: list[Unit]) -> int:
    """Return the index of the first phrase that says where from, or their count."""
    return next((i for i, unit in enumerate(units) if unit.preposition in _SOURCES), len(units))


def _phrases(units: list[Unit]) -> list[Phrase]:
    return [unit.phrase for unit in units]


def _recipient(graph: Graph, command: Command, *, target: str) -> list[Phrase]:
    """Return "to me" for "hand it to me", which the ERG reads as "hand me it"."""
    third = graph.argument(command.event, "ARG3")
    if (
        third is None
        or graph.part(third) is not Part.NOUN
        or graph.start(third) < graph.start(target)
    ):
        return []
    parts: list[str | Mention] = ["to", *mentions(graph, third)]
    return [Phrase(parts=tuple(parts))]
