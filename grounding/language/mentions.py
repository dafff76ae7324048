"""What a noun node is called: its symbols in spoken order, the noun last."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Final

from grounding.language.drafts import Mention, Reference
from grounding.language.graph import Graph, Part
from grounding.language.lexicon import CORRECTION, lexicon
from grounding.language.numerals import CARDINALS, ORDINALS

Words = tuple[str, ...]

_PERSONS: Final = {("1", "sg"): "me", ("1", "pl"): "us", ("2", ""): "you", ("2", "sg"): "you"}
_THIRD: Final = {"m": "him", "f": "her"}
_EXCLUDING: Final = frozenset({"but+not", "not", "but"})


class ChoiceLeft(Exception):  # noqa: N818 - no error of ours: the speaker left it open
    """The noun phrase holds an "or"."""


def conjuncts(graph: Graph, x: str) -> list[str]:
    """Return the noun nodes that a conjunction means, in order; what it excludes is out.

    Raises:
        ChoiceLeft: for "or".
    """
    if graph.part(x) is not Part.CONJUNCTION:
        return [x]
    lemma = graph.predicate(x).lemma
    if lemma in ("or", "nor"):
        raise ChoiceLeft
    arguments = graph.arguments(x)
    kept = arguments[:1] if lemma in _EXCLUDING else arguments
    kept = arguments[-1:] if lemma == CORRECTION else kept
    return [each for argument in kept for each in conjuncts(graph, argument)]


def mentions(graph: Graph, x: str) -> list[Mention]:
    """Return the mentions that a noun node stands for.

    There are several for a conjunction, and for "the red and blue cubes": no cube is both. "The
    red and the blue cube" lends its noun to the first, "the red cube, no, the blue" to the last.
    """
    found = lent([mention for each in conjuncts(graph, x) for mention in _of_one(graph, each)])
    taken_back = replaced(graph, x)
    lenders = [] if taken_back is None else mentions(graph, taken_back)
    if not lenders or len(found) != 1:
        return found
    return [with_noun_of(found[0], lender=lenders[-1])]


def replaced(graph: Graph, x: str) -> str | None:
    """Return the noun node that a correction takes back; None where `x` is no correction."""
    correction = graph.part(x) is Part.CONJUNCTION and graph.predicate(x).lemma == CORRECTION
    return graph.argument(x, "ARG1") if correction and graph.argument(x, "ARG2") else None


def lent(mentions_in_order: Sequence[Mention]) -> list[Mention]:
    """Return mentions where each that lacks its noun has that of the next."""
    found = list(mentions_in_order)
    for i in range(len(found) - 2, -1, -1):
        found[i] = with_noun_of(found[i], lender=found[i + 1])
    return found


def with_noun_of(one: Mention, *, lender: Mention) -> Mention:
    """Return a mention that lacks its noun with that of another."""
    classes = lexicon().classes
    bare = one.reference is Reference.NOUN_MISSING and bool(one.words)
    colour = (
        one.reference is Reference.NAMED and one.words[-1:] and one.noun_at == len(one.words) - 1
    )
    if not bare and not (colour and one.words[-1] in classes):
        return one
    if lender.reference is not Reference.NAMED or not lender.words or lender.words[-1] in classes:
        return one
    rest = lender.words[min(len(one.words), lender.noun_at) :]
    rest = tuple(word for word in rest if not _excluded(word, by=one.words))
    nouns = len(lender.words) - lender.noun_at
    words = (*one.words, *rest)
    return replace(
        one, words=words, noun_at=len(words) - nouns, reference=Reference.NAMED,
        plural=False, unknown=(*one.unknown, *(w for w in lender.unknown if w in rest)),
    )  # fmt: skip


def _excluded(word: str, *, by: Sequence[str]) -> bool:
    """Whether a word is of the same class as one of the others: no cube is red and blue."""
    classes = lexicon().classes
    return word in classes and any(classes.get(other) == classes[word] for other in by)


def _of_one(graph: Graph, x: str) -> list[Mention]:
    label = graph.label(x)
    if label == "pron":
        return [_pronoun(graph, x)]
    if label == "part_of":
        return _of_part(graph, x)
    modifiers = _modifiers(graph, x)
    head, reference = _head(graph, x)
    found = []
    for chosen in product(*(words for _, words in modifiers)):
        before = tuple(word for words in chosen for word in words if word)
        adjectives = sum(len(w) for (noun, _), w in zip(modifiers, chosen, strict=True) if not noun)
        head = tuple(word for word in head if word)
        known = Reference.PRONOUN if reference is Reference.NOUN_MISSING and (
            not before and _is_demonstrative(graph, x)) else reference  # fmt: skip
        found.append(
            Mention(
                words=(*before, *head),
                noun_at=adjectives,
                reference=known,
                plural=graph.is_plural(x),
                text=_text(graph, x),
                unknown=_unknown(graph, x),
            )
        )
    return found


def _pronoun(graph: Graph, x: str) -> Mention:
    properties = graph.node(x).properties
    person, number = properties.get("PERS", "3"), properties.get("NUM", "")
    spoken = _PERSONS.get((person, number))
    if spoken is not None:
        return Mention(words=(spoken,), text=spoken)
    gender = _THIRD.get(properties.get("GEND", "").split("-")[0])
    if gender is not None:
        return Mention(words=(gender,), text=gender)
    plural = number == "pl"
    return Mention(words=(), reference=Reference.PRONOUN, plural=plural,
                   text="them" if plural else "it")  # fmt: skip


def _of_part(graph: Graph, x: str) -> list[Mention]:
    """Return "the bigger of the two cubes" as a big cube, "all of them" as they."""
    whole = graph.argument(x, "ARG1")
    if whole is None:
        return [Mention(words=(), reference=Reference.NOUN_MISSING, text="one of them")]
    words = tuple(word for _, options in _modifiers(graph, x) for word in options[0])
    return [
        replace(one, words=(*words, *one.words), noun_at=one.noun_at + len(words),
                unknown=(*one.unknown, *_unknown(graph, x)))
        for one in mentions(graph, whole)
    ]  # fmt: skip


def _head(graph: Graph, x: str) -> tuple[Words, Reference]:
    node, predicate = graph.node(x), graph.predicate(x)
    if node.predicate == "generic_entity":
        return (), Reference.NOUN_MISSING
    if node.predicate == "card":
        return (_spelled(graph, x, names=CARDINALS),), Reference.NAMED
    if node.predicate == "named":
        return (str(node.carg).lower(),), Reference.NAMED
    if node.predicate == "place_n" or not predicate.lemma:
        return (), Reference.NAMED
    words = tuple(predicate.lemma.lower().split("+"))
    colour = lexicon().classes.get(predicate.lemma) == "colour"
    if predicate.part is Part.ADJECTIVE and not colour:
        return words, Reference.NOUN_MISSING
    return words, Reference.NAMED


def _is_demonstrative(graph: Graph, x: str) -> bool:
    return graph.quantifier(x).startswith(("_this", "_that", "_these", "_those"))


def _text(graph: Graph, x: str) -> str:
    node = graph.node(x)
    end = int(node.cto)
    start = min([graph.start(x), *(graph.start(each) for each, _ in _describing(graph, x))])
    return graph.sentence[max(0, start) : max(0, end)] or str(node.predicate)


def _modifiers(graph: Graph, x: str) -> list[tuple[bool, list[Words]]]:
    """Return what stands before the noun: whether it is a noun itself, and its alternatives."""
    ordered = _in_order(graph, x)
    result: list[tuple[bool, list[Words]]] = []
    for node_id, is_noun in ordered:
        words = _modifier_words(graph, node_id)
        pair = _pair_of(graph, node_id)
        if pair is not None and graph.predicate(pair).lemma == "or":
            raise ChoiceLeft
        pair = _pair_of(graph, node_id)
        last = (
            result[-1][1]
            if result and pair and pair == _pair_of(graph, _before(ordered, node_id))
            else None
        )
        if last is not None and graph.is_plural(x) and _excluded(words[0], by=last[-1]):
            last.append(words)
        else:
            result.append((is_noun, [words]))
    return result


def _in_order(graph: Graph, x: str) -> list[tuple[str, bool]]:
    """Return what describes a noun as it was spoken; from behind the noun it goes before it.

    The nouns right before the head belong to it: "the lego brick that is clean" is clean first.
    """
    ordered = sorted(_describing(graph, x), key=lambda found: graph.start(found[0]))
    before = [each for each in ordered if graph.start(each[0]) < graph.start(x)]
    first = len(before)
    while first and before[first - 1][1]:
        first -= 1
    return [*before[:first], *ordered[len(before) :], *before[first:]]


def _before(ordered: Sequence[tuple[str, bool]], node_id: str) -> str:
    ids = [each for each, _ in ordered]
    return ids[ids.index(node_id) - 1]


def _pair_of(graph: Graph, node_id: str) -> str | None:
    """Return the outermost conjunction that holds an adjective, if any."""
    above = [each for each in graph.parents(node_id) if graph.part(each) is Part.CONJUNCTION]
    return (_pair_of(graph, above[0]) or above[0]) if above else None


def _describing(graph: Graph, x: str) -> list[tuple[str, bool]]:
    """Return the nodes that describe a noun by words of their own, and whether each is a noun."""
    found = []
    for source in graph.into(x):
        label = graph.label(source)
        if label == "compound":
            modifier = graph.argument(source, "ARG2")
            if modifier is not None:
                found.append((modifier, True))
        elif label == "ord" or (graph.part(source) is Part.ADJECTIVE and _is_plain(graph, source)):
            found.append((source, False))
    return found


def _is_plain(graph: Graph, adjective: str) -> bool:
    """Whether an adjective describes by itself: not denied, without a phrase of its own."""
    label = graph.label(adjective)
    if graph.node(adjective).type == "x" or graph.predicate(adjective).lemma in ("there", "here"):
        return False
    return not any(
        graph.label(source) == "neg"
        or (graph.part(source) is Part.PREPOSITION and graph.predicate(source).lemma != "than")
        for source in graph.into(adjective)
    ) and not label.endswith("_x_deg")


def _modifier_words(graph: Graph, node_id: str) -> Words:
    node, predicate = graph.node(node_id), graph.predicate(node_id)
    if node.predicate == "ord":
        return (_spelled(graph, node_id, names=ORDINALS),)
    if node.predicate in ("card", "named"):
        return (_spelled(graph, node_id, names=CARDINALS),)
    before = tuple(word for _, options in _modifiers(graph, node_id) for word in options[0])
    return (*before, *predicate.lemma.lower().split("+"))


def _spelled(graph: Graph, node_id: str, *, names: Sequence[str]) -> str:
    """Return a number or name as it was spoken, or spelled where the sentence is not at hand."""
    node = graph.node(node_id)
    spoken, carg = graph.sentence[node.cfrom : node.cto].lower(), str(node.carg)
    if spoken.isalpha() or spoken.isdigit():
        return spoken
    return names[int(carg)] if carg.isdigit() and int(carg) < len(names) else carg.lower()


def _unknown(graph: Graph, x: str) -> Words:
    nodes = [x, *(each for each, _ in _describing(graph, x))]
    return tuple(
        graph.predicate(each).lemma for each in sorted(nodes, key=graph.start)
        if graph.predicate(each).unknown
    )  # fmt: skip
