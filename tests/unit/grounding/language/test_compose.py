"""What the embedded grammar builds is genuine EDS."""

import pytest
from delphin.codecs import eds as native
from delphin.codecs import edsjson, edspenman

from grounding.language.backends.embedded import Embedded
from grounding.language.verbs import default_verbs
from tests.plans import all_plans

EMBEDDED = Embedded(default_verbs())
SENTENCES = [each.sentence for each in all_plans()]


def labels(sentence):
    return {node.predicate for node in EMBEDDED.readings(sentence)[0].nodes}


def is_connected(eds):
    beside = {node.id: set() for node in eds.nodes}
    for source, _, target in eds.edges:
        beside[source].add(target)
        beside[target].add(source)
    reached, todo = set(), [eds.top]
    while todo:
        node = todo.pop()
        if node not in reached:
            reached.add(node)
            todo.extend(beside[node])
    return len(reached) == len(eds.nodes)


@pytest.mark.parametrize("start", range(0, len(SENTENCES), 100))
def test_every_reading_is_connected_and_survives_the_codecs(start):
    found = [eds for each in SENTENCES[start : start + 100] for eds in EMBEDDED.readings(each)]
    assert found
    for eds in found:
        assert is_connected(eds)
        assert native.decode(native.encode(eds)) == eds
        assert edsjson.decode(edsjson.encode(eds)) == eds
        again = edspenman.decode(edspenman.encode(eds))
        assert again.top == eds.top
        assert {(n.id, n.predicate, n.carg) for n in again.nodes} == {
            (n.id, n.predicate, n.carg) for n in eds.nodes
        }
        assert sorted(again.edges) == sorted(eds.edges)


def test_the_vocabulary_is_the_ergs():
    assert {"_pick_v_up", "_the_q", "_red_a_1", "_block_n_of", "pron", "pronoun_q"} <= labels(
        "pick up the red block"
    )
    assert {"_put_v_1", "_on_p_loc", "_left_n_of"} <= labels("put it on the left of the cube")
    assert {"_next+to_p", "compound", "udef_q"} <= labels("put the cup next to the steak knife")
    assert {"ord", "superl", "card"} <= labels(
        "put the first cube on the biggest of the two blocks"
    )
    assert "_could_v_modal" in labels("could you take the cup")
    assert "neg" in labels("don't take the cup")
    assert {"_glorpy_a_unknown", "_wug_n_unknown"} <= labels("take the glorpy wug")


def test_a_verb_of_placing_has_its_place_as_third_argument():
    eds = EMBEDDED.readings("put the cube on the block")[0]
    by_label = {node.predicate: node for node in eds.nodes}
    put, on = by_label["_put_v_1"], by_label["_on_p_loc"]
    assert put.edges["ARG3"] == on.id
    assert on.edges == {"ARG1": by_label["_cube_n_1"].id, "ARG2": by_label["_block_n_of"].id}
    assert (put.cfrom, put.cto) == (0, 3)
