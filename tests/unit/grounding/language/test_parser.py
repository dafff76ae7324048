"""Narration becomes abstract instructions."""

from grounding.language import default_parser


def test_a_pronoun_takes_the_target_of_an_earlier_text():
    first, second = default_parser().parse_discourse(
        ["now pick up the red cell", "put it on top of the blue cell"]
    )
    assert first.instructions[0].location == "red-cell-location"
    assert second.instructions[0].target == ("red", "cell")
    assert second.instructions[0].location == "on-top-of-blue-cell"
    assert second.instructions[0].resolved_from == 0


def test_a_direction_is_part_of_the_location():
    result = default_parser().parse("place the red block to the right of the yellow block")
    assert result.instructions[0].location == "to-right-of-yellow-block"
