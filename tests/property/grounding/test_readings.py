"""No reading, however broken, raises or yields half an instruction."""

from delphin.eds import EDS, Node
from delphin.lnk import Lnk
from hypothesis import given, settings
from hypothesis import strategies as st

from grounding.language.backends.embedded import Embedded
from grounding.language.parser import Parser
from grounding.language.verbs import default_verbs

EMBEDDED = Embedded(default_verbs())
PARSER = Parser(EMBEDDED)
SENTENCES = (
    "put the steak knife on the left of the red block and the second cup between the plates",
    "take the red cube, no, the blue one, and don't drop it",
    "after you take the biggest of the cubes that lie on the tray, could you hand them to me",
    "move cell two over there or turn it",
)
READINGS = [(each, EMBEDDED.readings(each)[0]) for each in SENTENCES]
LABELS = sorted(
    {node.predicate for _, eds in READINGS for node in eds.nodes}
    | {"_but+not_c", "_if_x_then", "_lift_n_1", "place_n", "unknown", "loc_nonsp", "weird", "_"}
)
ROLES = ("ARG1", "ARG2", "ARG3", "BV", "ARG", "L-INDEX")
CARGS = (None, "", "-1", "9" * 400)
SPANS = (None, Lnk.charspan(-5, 3), Lnk.charspan(900, 2))


@st.composite
def broken_readings(draw):
    """Return a sentence with a reading of it, a few of its nodes changed or gone."""
    sentence, eds = draw(st.sampled_from(READINGS))
    ids = [node.id for node in eds.nodes]
    nodes = []
    for node in eds.nodes:
        change = draw(
            st.sampled_from(("none", "none", "label", "edge", "carg", "lnk", "type", "gone"))
        )
        if change == "gone":
            continue
        label = draw(st.sampled_from(LABELS)) if change == "label" else node.predicate
        edges = dict(node.edges)
        if change == "edge":
            edges[draw(st.sampled_from(ROLES))] = draw(st.sampled_from([*ids, "x999"]))
        carg = draw(st.sampled_from(CARGS)) if change == "carg" else node.carg
        lnk = draw(st.sampled_from(SPANS)) if change == "lnk" else node.lnk
        kind = draw(st.sampled_from(("e", "x", "i", None))) if change == "type" else node.type
        nodes.append(
            Node(
                node.id,
                label,
                type=kind,
                edges=edges,
                properties=node.properties,
                carg=carg,
                lnk=lnk,
            )
        )
    return sentence, EDS(top=draw(st.sampled_from([eds.top, *ids, None])), nodes=nodes)


@settings(max_examples=300, deadline=None)
@given(broken_readings())
def test_a_broken_reading_gives_whole_instructions_or_an_error(broken):
    sentence, eds = broken
    result = PARSER.parse_reading(sentence, eds)
    assert bool(result.error) != bool(result.instructions)
    for each in result.instructions:
        assert each.target
        assert all(each.target)
        assert each.location.strip("-")
