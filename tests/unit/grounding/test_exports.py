import re

import numpy as np

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


def test_a_pddl_problem_uses_only_what_it_and_its_domain_declare() -> None:
    plan = plan_of(3)
    domain, problem = parsed(to_pddl_domain(plan)), parsed(to_pddl(plan))
    arity = {each[0]: sum(x[0] == "?" for x in each) for each in part(domain, ":predicates")}
    objects = {each for each in part(problem, ":objects") if each not in {"-", "thing", "place"}}
    assert len(objects) == 6
    (goal,) = part(problem, ":goal")
    facts = part(problem, ":init") + goal[1:]
    assert len(goal) == 3
    for fact in facts:
        assert arity[fact[0]] == len(fact) - 1
        assert set(fact[1:]) <= objects


def test_a_plan_of_nothing_is_still_a_problem() -> None:
    nothing = GroundedPlan(session="", revision=1, scale="metric", instructions=())
    assert part(parsed(to_pddl(nothing)), ":objects") == []
    assert parsed(to_pddl_domain(nothing))[0] == "define"
    assert "<Sequence" in to_behavior_tree(nothing)
    assert to_json_lines(nothing) == ""
