import pytest
from hypothesis import given
from hypothesis import strategies as st

from gazemap.errors import InputError
from services.wire import grounding, queries

times = st.integers(min_value=0, max_value=2**62)
small = st.integers(min_value=0, max_value=10_000)
words = st.text(max_size=20)
values = st.none() | st.booleans() | st.floats(-1e6, 1e6) | words | st.lists(small, max_size=3)
documents = st.dictionaries(words, values | st.dictionaries(words, values, max_size=3), max_size=4)


@given(times, small, documents)
def test_plan_and_symbols(t_ns, revision, document):
    plan = grounding.PlanMessage(t_ns=t_ns, revision=revision, plan=document)
    assert grounding.decode_plan(grounding.encode_plan(plan)) == plan
    symbols = grounding.SymbolsMessage(t_ns=t_ns, symbols=document)
    assert grounding.decode_symbols(grounding.encode_symbols(symbols)) == symbols


@given(times, small, small, documents)
def test_instruction(t_ns, revision, index, document):
    sent = grounding.InstructionMessage(
        t_ns=t_ns, revision=revision, index=index, instruction=document
    )
    assert grounding.decode_instruction(grounding.encode_instruction(sent)) == sent


@given(times, small, words, st.lists(words, max_size=3), st.none() | words)
def test_question(t_ns, index, text, asked, object_id):
    sent = grounding.Question(
        t_ns=t_ns, instruction_index=index, text=text, words=tuple(asked), object_id=object_id
    )
    assert grounding.decode_question(grounding.encode_question(sent)) == sent


@given(st.lists(words, max_size=3), words, st.lists(documents, max_size=3))
def test_parse(sentences, backend, plans):
    request = queries.ParseRequest(sentences=tuple(sentences), backend=backend)
    assert queries.decode_parse_request(queries.encode_parse_request(request)) == request
    answer = queries.ParseAnswer(plans=tuple(plans))
    assert queries.decode_parse_answer(queries.encode_parse_answer(answer)) == answer


@given(st.lists(words, max_size=3), documents)
def test_ground_and_teach(sentences, document):
    request = queries.GroundRequest(sentences=tuple(sentences))
    assert queries.decode_ground_request(queries.encode_ground_request(request)) == request
    assert queries.decode_ground_answer(queries.encode_ground_answer(document)) == document
    assert queries.decode_teach_request(queries.encode_teach_request(document)) == document
    assert queries.decode_teach_answer(queries.encode_teach_answer(document)) == document


@given(st.lists(st.tuples(words, st.binary(max_size=9), st.none() | st.floats(0.1, 9))), words)
def test_classify(patches, table):
    sent = tuple(queries.NamedPatch(name=n, image=i, mm_per_px=s) for n, i, s in patches)
    assert queries.decode_classify_request(queries.encode_classify_request(sent)) == sent
    assert queries.decode_classify_answer(queries.encode_classify_answer(table)) == table


@pytest.mark.parametrize(
    "decode",
    [
        grounding.decode_plan,
        grounding.decode_instruction,
        grounding.decode_symbols,
        grounding.decode_question,
        queries.decode_parse_request,
        queries.decode_parse_answer,
        queries.decode_ground_request,
        queries.decode_ground_answer,
        queries.decode_classify_request,
        queries.decode_classify_answer,
        queries.decode_teach_request,
        queries.decode_teach_answer,
    ],
)
@given(payload=st.binary(max_size=60) | st.just(b"\x08\x01\x22\x01["))
def test_garbage_is_an_input_error_of_one_line(decode, payload):
    line = ""
    try:
        decode(payload)
    except InputError as error:
        line = str(error)
    assert "\n" not in line
    for wrong in (b"", b"\x08\x07"):
        with pytest.raises(InputError):
            decode(wrong)


def test_a_number_that_is_none_is_the_callers_bug():
    with pytest.raises(ValueError, match="JSON"):
        grounding.encode_symbols(grounding.SymbolsMessage(t_ns=0, symbols={"mean": float("nan")}))


@pytest.mark.parametrize("text", ["", "[1]", "{"])
def test_a_text_that_is_no_object_is_refused(text):
    with pytest.raises(InputError, match="no JSON object"):
        grounding.document_of(text, stream="plan")
