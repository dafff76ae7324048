"""Hundreds of sentences of every form, with the plan that a careful reader gives them."""

import pytest

from grounding.language.backends.embedded import Embedded
from grounding.language.parser import Parser
from grounding.language.verbs import default_verbs
from tests.plans import all_plans, written

PLANS = all_plans()


@pytest.fixture(scope="module")
def parser():
    return Parser(Embedded(default_verbs()))


def test_there_are_at_least_300_sentences():
    assert len({each.sentence for each in PLANS}) >= 300


@pytest.mark.parametrize("planned", PLANS, ids=lambda each: each.sentence)
def test_a_sentence_gives_its_plan(planned, parser):
    result = parser.parse(planned.sentence)
    assert planned.is_met_by(result), f"{written(result.instructions)} | {result.error}"
