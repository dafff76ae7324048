"""Texts become abstract instructions; pronouns reach over the discourse."""

import pytest

from grounding.errors import BackendError, ConfigError
from grounding.language import Parser, default_parser, parser_for
from grounding.language.backends.embedded import Embedded
from grounding.language.config import BackendChoice, LanguageConfig
from grounding.language.verbs import default_verbs
from grounding.types import Action

EMBEDDED = LanguageConfig(backend=BackendChoice.EMBEDDED)


@pytest.fixture
def parser():
    return parser_for(EMBEDDED)


def test_a_pronoun_takes_the_target_of_an_earlier_text():
    first, second = default_parser().parse_discourse(
        ["now pick up the red cell", "put it on top of the blue cell"]
    )
    assert first.instructions[0].location == "red-cell-location"
    assert second.instructions[0].target == ("red", "cell")
    assert second.instructions[0].location == "on-top-of-blue-cell"
    assert second.instructions[0].resolved_from == 0


def test_resolved_from_counts_through_the_whole_discourse(parser):
    results = parser.parse_discourse(["take the cup and the fork", "hello", "put it on the tray"])
    assert [len(each.instructions) for each in results] == [2, 0, 1]
    assert results[2].instructions[0].target == ("fork",)
    assert results[2].instructions[0].resolved_from == 1


def test_they_are_several(parser):
    results = parser.parse_discourse(["take the cup", "take the fork", "put them on the tray"])
    last = results[2].instructions
    assert [each.target for each in last] == [("cup",), ("fork",)]
    assert [each.resolved_from for each in last] == [0, 1]


def test_each_text_alone_is_a_discourse_of_its_own(parser):
    parser.parse("take the cup")
    assert "nothing earlier" in str(parser.parse("put it on the tray").error)


def test_a_refused_sentence_leaves_the_discourse_as_it_was(parser):
    results = parser.parse_discourse(
        ["take the cup", "take the red fork and frobnicate it", "drop it"]
    )
    assert results[1].instructions == ()
    assert results[2].instructions[0].target == ("cup",)


def test_a_sentence_that_is_no_instruction_keeps_its_own_error(parser):
    result = parser.parse("The cube is red. Take it easy. Take the cube.")
    assert result.error is None
    assert len(result.instructions) == 1
    assert [each.error is None for each in result.parses] == [False, False, True]


def test_unknown_words_are_marked(parser):
    (one,) = parser.parse("put the glorpy cube on the wug").instructions
    assert one.unknown == ("glorpy", "wug")
    assert parser.parse("take the red cube").instructions[0].unknown == ()


def test_readings_are_kept(parser):
    (parse,) = parser.parse("pick up the red cube").parses
    assert parse.readings
    assert parse.readings[0].top in {node.id for node in parse.readings[0].nodes}


def test_a_verb_is_taught_by_configuration():
    config = LanguageConfig(backend=BackendChoice.EMBEDDED, verbs={"ponder": "look"})
    parser = parser_for(config)
    assert parser.parse("ponder the cube").instructions[0].action is Action.POINT
    assert parser.parse("I am pondering the cube").instructions[0].action is Action.POINT


def test_an_unknown_verb_says_how_to_teach_it(parser):
    error = parser.parse("ponder the cube").error
    assert '"ponder"' in str(error)
    assert "ponder=" in str(error)


def test_a_verb_that_resembles_none_is_refused():
    with pytest.raises(ConfigError, match="choose one of"):
        parser_for(LanguageConfig(verbs={"ponder": "wonder"}))
    with pytest.raises(ConfigError, match="letters"):
        parser_for(LanguageConfig(verbs={"p0nder!": "take"}))


class Failing:
    name = "failing"

    def readings(self, sentence):
        raise BackendError(f"no parse of\n{sentence}")


def test_a_backend_that_fails_is_one_line_and_stops_nothing():
    results = Parser(Failing()).parse_discourse(["take the cup", "take the fork"])
    assert [each.error for each in results] == [
        "no parse of take the cup",
        "no parse of take the fork",
    ]


class Second:
    """A backend whose first reading is a fragment and whose second is the command."""

    name = "second"

    def readings(self, sentence):
        embedded = Embedded(default_verbs())
        return [*embedded.readings("the cup"), *embedded.readings(sentence)]


def test_the_first_reading_that_gives_an_instruction_is_taken():
    (parse,) = Parser(Second()).parse("take the cup").parses
    assert len(parse.instructions) == 1
    assert "_take_v_1" in {node.predicate for node in parse.readings[0].nodes}


class Denied:
    """A backend whose first reading is denied."""

    name = "denied"

    def readings(self, sentence):
        embedded = Embedded(default_verbs())
        return [*embedded.readings("don't take the cup"), *embedded.readings(sentence)]


def test_a_denied_reading_is_never_passed_over():
    result = Parser(Denied()).parse("take the cup")
    assert result.instructions == ()
    assert "negated" in str(result.error)
