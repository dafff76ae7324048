"""The grounded plan for other programs: PDDL, a behaviour tree, JSON lines."""

import json
import re
from typing import Final
from xml.etree import ElementTree as ET

import numpy as np

from grounding.places import parse_location
from grounding.plan import GroundedInstruction, GroundedPlan, Status
from grounding.types import FloatArray

_NODES: Final = {"pick": "Pick", "place": "Place", "move": "Place"}
_ASK_HUMAN: Final = "AskHuman"
_POINT: Final = "std::vector<double>"
_PORTS: Final = {
    "object": ("std::string", "which thing, as in objects.json; empty if vision has none there"),
    "target": (_POINT, "x;y;z of its centre before, in world"),
    "location": (_POINT, "x;y;z of its centre after, in world"),
    "orientation": (_POINT, "x;y;z;w, the quaternion of its yaw"),
    "size": (_POINT, "its extents x;y;z"),
    "question": ("std::string", "what the human is to answer"),
}


def to_json_lines(plan: GroundedPlan) -> str:
    """Return one instruction a line, each with the plan's session and revision."""
    head = {"session": plan.session, "revision": plan.revision}
    return "".join(
        json.dumps(head | each.to_json(), allow_nan=False) + "\n" for each in plan.instructions
    )


def to_pddl_domain(plan: GroundedPlan) -> str:
    """Return the PDDL domain of a plan's problem: picking, placing, and the words as predicates.

    No type is called as an action is: some readers refuse that.
    """
    words = sorted({_atom(word) for each in _sure(plan) for word in each.spoken.instruction.target})
    lines = [
        "(define (domain tabletop)",
        "  (:requirements :strips :typing)",
        "  (:types thing location)",
        "  (:predicates",
        *(f"    (is-{word} ?thing - thing)" for word in words),
        "    (at ?thing - thing ?place - location)",
        "    (located ?place - location)",
        "    (holding ?thing - thing)",
        "    (hand-empty)",
        "  )",
        "  (:action pick",
        "    :parameters (?thing - thing ?place - location)",
        "    :precondition (and (at ?thing ?place) (located ?place) (hand-empty))",
        "    :effect (and (holding ?thing) (not (at ?thing ?place)) (not (hand-empty)))",
        "  )",
        "  (:action place",
        "    :parameters (?thing - thing ?place - location)",
        "    :precondition (and (holding ?thing) (located ?place))",
        "    :effect (and (at ?thing ?place) (hand-empty) (not (holding ?thing)))",
        "  )",
        ")",
    ]
    return "\n".join(lines) + "\n"


def to_pddl(plan: GroundedPlan) -> str:
    """Return a PDDL problem: the things, their words as facts, and where they are to go.

    Only what is grounded is a fact; the rest is named in comments. Predicates: `(is-WORD ?thing)`,
    `(at ?thing ?place)`, and `(located ?place)` with the position behind it as a comment.
    """
    sure = _sure(plan)
    things = {_thing(each): each for each in reversed(sure)}
    init, goal, places = ["(hand-empty)"], {}, []
    for name, each in sorted(things.items()):
        init += [f"(is-{_atom(word)} {name})" for word in each.spoken.instruction.target]
        init.append(f"(at {name} start-{name})")
        places.append((f"start-{name}", each.target.spot.position_world if each.target else None))
    for each in sure:
        place = parse_location(each.spoken.instruction.location)
        if each.location is None or place.relation is None:
            continue
        name = f"place-{each.spoken.index}"
        places.append((name, each.location.position_world))
        goal[_thing(each)] = f"(at {_thing(each)} {name})"
    typed = [(sorted(things), "thing"), ([name for name, _ in places], "location")]
    lines = [
        f"(define (problem {_atom(plan.session)})",
        "  (:domain tabletop)",
        "  (:objects",
        *(f"    {' '.join(names)} - {kind}" for names, kind in typed if names),
        "  )",
        "  (:init",
        *(f"    {fact}" for fact in dict.fromkeys(init)),
        *(f"    (located {name}) ; {_metres(position)}" for name, position in places),
        "  )",
        "  (:goal (and",
        *(f"    {fact}" for _, fact in sorted(goal.items())),
        "  ))",
        *(
            f"  ; not grounded: {' '.join(each.spoken.sentence.split())} ({each.status})"
            for each in plan.instructions
            if each.status is not Status.GROUNDED
        ),
        ")",
    ]
    return "\n".join(lines) + "\n"


def _sure(plan: GroundedPlan) -> list[GroundedInstruction]:
    return [each for each in plan.instructions if each.status is Status.GROUNDED]


def to_behavior_tree(plan: GroundedPlan) -> str:
    """Return BehaviorTree.CPP (version 4) XML: a sequence of picks, places and other actions.

    An instruction that is not grounded becomes an `AskHuman` node, so that a robot stops there.
    The nodes' models name the ports that a robot's nodes provide; Groot shows nothing without them.
    """
    root = ET.Element("root", BTCPP_format="4", main_tree_to_execute="Plan")
    tree = ET.SubElement(root, "BehaviorTree", ID="Plan")
    sequence = ET.SubElement(tree, "Sequence", name=_instance_name(plan.session))
    for each in plan.instructions:
        _add_node(sequence, each)
    if not plan.instructions:  # a sequence must not be empty
        ET.SubElement(sequence, "AlwaysSuccess")
    _add_models(root, sequence)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode", xml_declaration=False) + "\n"


def _add_node(parent: ET.Element, each: GroundedInstruction) -> None:
    action = str(each.spoken.instruction.action)
    name = _instance_name(f"{each.spoken.index}: {each.spoken.sentence}")
    if each.status is not Status.GROUNDED or each.target is None or each.location is None:
        text = _instance_name(each.question or each.reason or "")
        ET.SubElement(parent, "Action", ID=_ASK_HUMAN, name=name, question=text)
        return
    node = ET.SubElement(
        parent,
        "Action",
        ID=_NODES.get(action, action.capitalize()),
        name=name,
        object=each.target.object_id or "",
        target=_numbers(each.target.spot.position_world),
        location=_numbers(each.location.position_world),
    )
    if each.target.quat_xyzw is not None:
        node.set("orientation", _numbers(each.target.quat_xyzw))
    if each.target.size_m is not None:
        node.set("size", _numbers(each.target.size_m))


def _add_models(root: ET.Element, sequence: ET.Element) -> None:
    """Declare each node that the sequence uses, with the ports that it may be given."""
    used = sorted({node.get("ID", "") for node in sequence.iter("Action")})
    if not used:
        return
    models = ET.SubElement(root, "TreeNodesModel")
    for name in used:
        action = ET.SubElement(models, "Action", ID=name)
        for port, (kind, text) in _PORTS.items():
            if (port == "question") == (name == _ASK_HUMAN):
                ET.SubElement(action, "input_port", name=port, type=kind).text = text


def _instance_name(text: str) -> str:
    """Return a text as the value of an attribute: no characters that XML does not know."""
    return re.sub(r"[\x00-\x1f\x7f]+", " ", text)


def _thing(each: GroundedInstruction) -> str:
    found = each.target.object_id if each.target else None
    return _atom(found or "-".join(each.spoken.instruction.target))


def _atom(text: str) -> str:
    """Return a PDDL name: letters, digits and hyphens, begun by a letter."""
    name = re.sub(r"[^a-z0-9-]+", "-", text.lower()).strip("-") or "x"
    return name if name[0].isalpha() else f"x-{name}"


def _numbers(values: FloatArray) -> str:
    return ";".join(f"{value:.4f}" for value in np.asarray(values))


def _metres(position: FloatArray | None) -> str:
    return "unknown" if position is None else _numbers(position)
