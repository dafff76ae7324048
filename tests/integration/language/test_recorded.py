"""Against readings of a large grammar that were recorded: the traversal, and our own grammar."""

import json
from pathlib import Path

import pytest
from delphin.codecs import eds as native

from grounding.language.agreement import agreement
from grounding.language.backends.embedded import Embedded
from grounding.language.parser import Parser
from grounding.language.verbs import default_verbs
from tests.plans import read_plans, written

RECORDED = Path(__file__).parents[4] / "shared" / "data" / "eds" / "silver.jsonl"

pytestmark = pytest.mark.skipif(not RECORDED.exists(), reason=f"{RECORDED} is not there")


@pytest.fixture(scope="module")
def rows():
    lines = RECORDED.read_text(encoding="utf-8").splitlines()
    return {row["sentence"]: native.decode(row["eds_native"]) for row in map(json.loads, lines)}


@pytest.fixture(scope="module")
def embedded():
    return Embedded(default_verbs())


@pytest.fixture(scope="module")
def parser(embedded):
    return Parser(embedded)


def test_the_traversal_of_recorded_readings_is_right(rows, parser):
    plans = read_plans("silver_plans.txt")
    assert len(plans) >= 120
    wrong = [
        each.sentence for each in plans
        if not each.is_met_by(parser.parse_reading(each.sentence, rows[each.sentence]))
    ]  # fmt: skip
    assert len(wrong) <= 0.05 * len(plans), wrong


def test_the_embedded_grammar_is_right_on_the_same_sentences(parser):
    plans = read_plans("silver_plans.txt")
    wrong = [each.sentence for each in plans if not each.is_met_by(parser.parse(each.sentence))]
    assert len(wrong) <= 0.05 * len(plans), wrong


def test_recorded_and_embedded_readings_give_the_same_plans(rows, parser):
    differ, said = [], 0
    for sentence, eds in rows.items():
        theirs = written(parser.parse_reading(sentence, eds).instructions)
        ours = written(parser.parse(sentence).instructions)
        said += bool(theirs or ours)
        differ += [sentence] if theirs != ours else []
    assert said >= 200
    assert len(differ) <= 0.07 * said, differ


def test_predicates_and_edges_match_the_recorded_ones(rows, embedded):
    readings = {sentence: embedded.readings(sentence) for sentence in rows}
    pairs = [((readings[s][0] if readings[s] else None), rows[s]) for s in rows]
    found = agreement(pairs)
    assert 0.85 <= found.precision < 1.0
    assert 0.85 <= found.recall < 1.0
