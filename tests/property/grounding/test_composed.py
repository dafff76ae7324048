"""Sentences put together from parts whose meaning is known: the plan must be that of the parts."""

from dataclasses import dataclass

from hypothesis import given, settings
from hypothesis import strategies as st

from grounding.language.backends.embedded import Embedded
from grounding.language.parser import Parser
from grounding.language.verbs import default_verbs

PARSER = Parser(Embedded(default_verbs()))

SIZES = {"big": "big", "biggest": "big", "smaller": "small", "tiny": "tiny", "tallest": "tall"}
COLOURS = ("red", "blue", "green", "yellow", "white", "purple")
OTHERS = ("wooden", "plastic", "shiny", "glorpy", "first", "second", "last")
NOUNS = ("cube", "block", "cell", "ball", "bowl", "spoon", "wug", "dax", "steak knife", "toy car")
DETERMINERS = ("the", "the", "the", "a", "that", "my", "your", "this")
SIDES = ("to the left of", "on the right of", "in front of", "on top of", "in the middle of")
PLAIN = ("on", "in", "under", "behind", "beside", "near", "next to", "inside", "onto")
TAKING = ("pick up {}", "take {}", "grab {}", "lift {} up", "get {}", "pick {} up")
PLACING = ("put {}", "place {}", "set {} down", "lay {}", "stack {}", "drop {}")
MOVING = {"push {}": "push", "slide {}": "move", "move {}": "move", "pull {}": "pull"}
ASKING = (
    "{}", "please {}", "{} please", "could you {}?", "would you please {}", "now {}", "then {}",
    "first {}", "I {}", "now I {}", "I will {}", "I'm going to {}", "you should {}",
    "I want you to {}", "let's {}", "okay, {}", "um, {}", "go ahead and {}", "robot, {}",
)  # fmt: skip


@dataclass(frozen=True)
class Part:
    """Words with the symbols they stand for."""

    text: str
    symbols: tuple[str, ...]


@dataclass(frozen=True)
class Said:
    """A command with its instructions: (action, target, location)."""

    text: str
    plan: tuple[tuple[str, tuple[str, ...], str], ...]


@st.composite
def things(draw):
    """Return a noun phrase."""
    size = draw(st.sampled_from(["", "", *SIZES]))
    words = [draw(st.sampled_from(["", "", "", *OTHERS])), size]
    words += [draw(st.sampled_from(["", *COLOURS])), draw(st.sampled_from(NOUNS))]
    spoken = [word for word in words if word]
    symbols = [part for word in spoken for part in SIZES.get(word, word).split()]
    return Part(" ".join([draw(st.sampled_from(DETERMINERS)), *spoken]), tuple(symbols))


@st.composite
def places(draw, *, depth=0):
    """Return a prepositional phrase, perhaps with another on its landmark."""
    landmark = draw(things())
    if depth == 0 and draw(st.integers(0, 7)) == 0:
        other = draw(things())
        symbols = ("between", *landmark.symbols, "and", *other.symbols)
        return Part(f"between {landmark.text} and {other.text}", symbols)
    words = draw(st.sampled_from([*PLAIN, *SIDES]))
    found = Part(
        f"{words} {landmark.text}",
        (*(w for w in words.split() if w != "the"), *landmark.symbols),
    )
    if depth == 0 and draw(st.integers(0, 4)) == 0:
        more = draw(places(depth=1))
        return Part(f"{found.text} {more.text}", (*found.symbols, *more.symbols))
    return found


def own(thing):
    """Return the location of what stays where it is."""
    return "-".join((*thing.symbols, "location"))


@st.composite
def commands(draw, *, known=None):
    """Return one command; about `known`, called "it", if that is given."""
    thing = known or draw(things())
    spoken = "it" if known else thing.text
    kind = draw(st.sampled_from(["place", "move", "from", "front"] + ["take"] * (known is None)))
    place = draw(places())
    location = "-".join(place.symbols)
    if kind == "take":
        return Said(
            draw(st.sampled_from(TAKING)).format(spoken), (("pick", thing.symbols, own(thing)),)
        )
    if kind == "from":
        source = draw(things())
        at = "-".join(("from", *source.symbols))
        return Said(f"take {spoken} from {source.text}", (("pick", thing.symbols, at),))
    if kind == "move":
        verb = draw(st.sampled_from(sorted(MOVING)))
        return Said(
            f"{verb.format(spoken)} {place.text}", ((MOVING[verb], thing.symbols, location),)
        )
    verb = draw(st.sampled_from(PLACING))
    said = verb.format(spoken)
    text = f"{place.text} {said}" if kind == "front" and known is None else f"{said} {place.text}"
    return Said(text, (("place", thing.symbols, location),))


@st.composite
def several(draw):
    """Return a command, two in a row, or one about two things."""
    kind = draw(st.sampled_from(["one", "one", "row", "things"]))
    if kind == "one":
        return draw(commands())
    if kind == "things":
        left, right, place = draw(things()), draw(things()), draw(places(depth=1))
        at = "-".join(place.symbols)
        text = f"put {left.text} and {right.text} {place.text}"
        return Said(text, (("place", left.symbols, at), ("place", right.symbols, at)))
    thing = draw(things())
    first = Said(
        draw(st.sampled_from(TAKING)).format(thing.text), (("pick", thing.symbols, own(thing)),)
    )
    second = draw(commands(known=thing))
    link = draw(st.sampled_from([" and ", ", then ", " and then ", ". ", ". Now ", ", and "]))
    return Said(f"{first.text}{link}{second.text}", (*first.plan, *second.plan))


@settings(max_examples=400, deadline=None)
@given(several(), st.sampled_from(ASKING))
def test_the_plan_of_a_sentence_is_that_of_its_parts(said, asking):
    fronted = said.text.split()[0] in {*" ".join((*PLAIN, *SIDES)).split(), "between"}
    whole = fronted or ". " in said.text
    text = said.text if whole else asking.format(said.text)
    result = PARSER.parse(text)
    found = tuple((each.action.value, each.target, each.location) for each in result.instructions)
    assert found == said.plan, f"{text} | {result.error}"
