import dataclasses
import re
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from grounding.exports import to_behavior_tree, to_json_lines, to_pddl, to_pddl_domain
from grounding.pipeline import ground_session
from grounding.plan import GroundedPlan
from services.bench.glide import SceneConfig, draw_scene

Tree = list["Tree | str"]


def plan_of(seed: int) -> GroundedPlan:
    scene = draw_scene(
        SceneConfig(pairs=2, motion=True, times=True, sigma_m=0.01), np.random.default_rng(seed)
    )
    return ground_session(scene.demonstration, name="Drawn session 3!").plan


def parsed(text: str) -> Tree:
    """The lists of a PDDL file; a bracket too many or too few fails."""
    tokens = re.findall(r"[()]|[^\s()]+", re.sub(r";[^\n]*", "", text))
    stack: list[Tree] = [[]]
    for word in tokens:
        if word == "(":
            stack.append([])
        elif word == ")":
            inner = stack.pop()
            stack[-1].append(inner)
        else:
            assert re.fullmatch(r"[:?]?[a-z][a-z0-9-]*|-", word), word
            stack[-1].append(word)
    assert len(stack) == 1
    (tree,) = stack[0]
    assert isinstance(tree, list)
    return tree


def part(tree: Tree, name: str) -> Tree:
    (found,) = [each[1:] for each in tree if isinstance(each, list) and each[0] == name]
    return found


def xml_of(plan: GroundedPlan) -> ET.Element:
    return ET.fromstring(to_behavior_tree(plan))  # noqa: S314  what we wrote ourselves


def test_a_pddl_problem_uses_only_what_it_and_its_domain_declare() -> None:
    plan = plan_of(3)
    domain, problem = parsed(to_pddl_domain(plan)), parsed(to_pddl(plan))
    arity = {each[0]: sum(x[0] == "?" for x in each) for each in part(domain, ":predicates")}
    objects = {each for each in part(problem, ":objects") if each not in {"-", "thing", "location"}}
    assert len(objects) == 6
    (goal,) = part(problem, ":goal")
    facts = part(problem, ":init") + goal[1:]
    assert len(goal) == 3
    for fact in facts:
        assert arity[fact[0]] == len(fact) - 1
        assert set(fact[1:]) <= objects


def test_no_type_of_the_domain_is_called_as_an_action_is() -> None:
    domain = parsed(to_pddl_domain(plan_of(3)))
    actions = {each[1] for each in domain if isinstance(each, list) and each[0] == ":action"}
    assert actions == {"pick", "place"}
    assert not actions & set(part(domain, ":types"))


@pytest.mark.parametrize("count", [0, 4])
def test_other_readers_read_the_problem(count: int, tmp_path: Path) -> None:
    pddl = pytest.importorskip("pddl", reason="a reader of PDDL that is no dependency")
    plan = plan_of(3)
    plan = dataclasses.replace(plan, instructions=plan.instructions[:count])
    (tmp_path / "domain.pddl").write_text(to_pddl_domain(plan))
    (tmp_path / "problem.pddl").write_text(to_pddl(plan))
    domain = pddl.parse_domain(str(tmp_path / "domain.pddl"))
    problem = pddl.parse_problem(str(tmp_path / "problem.pddl"))
    assert problem.domain_name == domain.name
    assert len(problem.objects) == (6 if count else 0)


def test_a_tree_declares_each_node_with_the_ports_it_is_given() -> None:
    root = xml_of(plan_of(3))
    assert (root.get("BTCPP_format"), root.get("main_tree_to_execute")) == ("4", "Plan")
    (tree,) = root.findall("BehaviorTree")
    assert len(tree) == 1
    ports = {
        model.get("ID"): {port.get("name") for port in model}
        for model in root.findall("TreeNodesModel/Action")
    }
    nodes = list(tree.iter("Action"))
    assert len(nodes) == 4
    for node in nodes:
        assert set(node.keys()) - {"ID", "name"} <= ports[node.get("ID")]


def test_a_tree_is_xml_whatever_was_said_and_never_empty() -> None:
    plan = dataclasses.replace(plan_of(3), session='a\x00b <c> & "d"')
    root = xml_of(plan)
    assert root.find("BehaviorTree/Sequence").get("name") == 'a b <c> & "d"'
    nothing = dataclasses.replace(plan, instructions=())
    (sequence,) = xml_of(nothing).iter("Sequence")
    assert [node.tag for node in sequence] == ["AlwaysSuccess"]


def test_a_plan_of_nothing_is_still_a_problem() -> None:
    nothing = GroundedPlan(session="", revision=1, scale="metric", instructions=())
    assert part(parsed(to_pddl(nothing)), ":objects") == []
    assert parsed(to_pddl_domain(nothing))[0] == "define"
    assert "<Sequence" in to_behavior_tree(nothing)
    assert to_json_lines(nothing) == ""
