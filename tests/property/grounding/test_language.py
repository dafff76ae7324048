"""No text raises, hangs or yields a guess."""

import string
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grounding.language.backends.embedded import Embedded
from grounding.language.lexicon import lexicon
from grounding.language.parser import Parser
from grounding.language.verbs import default_verbs

PARSER = Parser(Embedded(default_verbs()))
LONGEST = 10_000
LIMIT_S = 1.0
WORDS_OF_GRAMMAR = [
    word for name in ("determiners", "directions", "conjunctions", "negations", "particles")
    for word in sorted(lexicon().closed[name])
] + ["it", "them", "one", "big", "cube", "block", "which", "that", "is", "I"]  # fmt: skip
WORDS = [*",.?'", "'s", *default_verbs().entries, *WORDS_OF_GRAMMAR, "wug", "zorp", "red", "blue"]


def assert_instructions_or_error(text):
    start = time.process_time()
    result = PARSER.parse(text)
    assert time.process_time() - start < LIMIT_S
    assert bool(result.error) != bool(result.instructions)
    assert result.sentence == text
    for each in result.instructions:
        assert each.target
        assert all(word and word == word.lower() for word in each.target)
        assert each.location
    return result


@settings(max_examples=150, deadline=None)
@given(st.text(max_size=300))
def test_any_text_gives_instructions_or_an_error(text):
    assert_instructions_or_error(text)


@settings(max_examples=300, deadline=None)
@given(st.lists(st.sampled_from(WORDS), max_size=40))
def test_any_order_of_the_grammars_own_words_does(words):
    assert_instructions_or_error(" ".join(words))


@settings(max_examples=10, deadline=None)
@given(st.lists(st.sampled_from(WORDS), min_size=1, max_size=12))
def test_long_texts_end_in_a_second(words):
    piece = " ".join(words)
    assert_instructions_or_error((piece + " ") * (LONGEST // (len(piece) + 1)))
    assert_instructions_or_error((piece + ". ") * (LONGEST // (len(piece) + 2)))


@pytest.mark.parametrize("piece", [",o?u,j ", "take it, no, j? ", "go?", "take a, b? "])
def test_many_short_sentences_end_in_a_second(piece):
    assert_instructions_or_error((piece * LONGEST)[:LONGEST])


@settings(max_examples=60, deadline=None)
@given(st.text(alphabet=string.ascii_lowercase + " ", max_size=60))
def test_letters_at_random_are_no_instruction_without_a_known_verb(text):
    result = assert_instructions_or_error(text)
    spoken = set(text.split())
    assert not result.instructions or spoken & set(PARSER.verbs.entries)


@settings(max_examples=60, deadline=None)
@given(st.text(alphabet=st.characters(min_codepoint=0x370), min_size=1, max_size=200))
def test_other_scripts_are_no_instruction(text):
    assert assert_instructions_or_error(text).error is not None


@settings(max_examples=100, deadline=None)
@given(
    st.sampled_from(["pick up", "take", "push", "open"]), st.sampled_from(["cube", "wug", "box"])
)
def test_a_denied_command_is_never_carried_out(verb, noun):
    for denial in ("do not", "don't", "never", "please don't", "you must not", "I would not"):
        assert assert_instructions_or_error(f"{denial} {verb} the {noun}").instructions == ()


@settings(max_examples=100, deadline=None)
@given(
    st.lists(st.sampled_from(["push the cube", "take it", "open the box"]), min_size=2, max_size=5),
    st.sampled_from(["don't", "never", "do not"]),
    st.sampled_from([" and ", ", ", ", and ", " or ", ". "]),
)
def test_several_denials_never_make_a_command(commands, denial, link):
    assert (
        assert_instructions_or_error(
            link.join(f"{denial} {each}" for each in commands)
        ).instructions
        == ()
    )


@pytest.mark.parametrize(
    "denial",
    ["don't", "never", "you must not", "I won't", "you should never", "I don't want you to"],
)
@pytest.mark.parametrize("link", ["and", "and then", "&", "or"])
def test_a_denial_reaches_over_and(denial, link):
    assert (
        assert_instructions_or_error(
            f"{denial} take the cup {link} put it on the tray"
        ).instructions
        == ()
    )
    assert (
        assert_instructions_or_error(
            f"{denial} open the box {link} put the cup in the box"
        ).instructions
        == ()
    )


def test_it_is_no_object_of_a_denied_verb_unless_that_is_said_again():
    assert (
        assert_instructions_or_error(
            "don't pick up the ball, turn it, and set it on the tray"
        ).instructions
        == ()
    )
    assert (
        assert_instructions_or_error("don't grab the jar, open it and take the lid").instructions
        == ()
    )
    (again,) = assert_instructions_or_error(
        "don't put the cup on the table, put it on the tray"
    ).instructions
    assert (again.target, again.location) == (("cup",), "on-tray")
    (other,) = assert_instructions_or_error(
        "you must not take the cup and you should take the plate"
    ).instructions
    assert other.target == ("plate",)
