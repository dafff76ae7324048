"""How fast sentences become instructions, and how the time grows with their length."""

from functools import partial
from time import process_time_ns
from typing import Final

from grounding.language.backends.ace import Ace, installed
from grounding.language.backends.embedded import Embedded
from grounding.language.config import LanguageConfig
from grounding.language.parser import Parser
from grounding.language.verbs import default_verbs
from services.bench.figures import Figure, median_ms

_SENTENCES: Final = (
    "pick up the red cube",
    "now I take the blue cell",
    "put the small blue cube on top of the big red block",
    "could you please place the cup between the plate and the bowl",
    "take the knife from the tray next to the plate and put it on the table",
    "grab the yellow and the green cell which are on the left of the box",
    "put the block that is on the table in the box and close it",
    "the red cube is on the table",
    "don't touch the glorpy wug",
)
_CLAUSE: Final = "put the small red cube on the left of the blue block and "
_SHORT, _LONG = 1, 5
_REPEATS: Final = 20


def run() -> list[Figure]:
    """Measure one sentence, the growth up to 60 words, and 10 000 characters."""
    parser = Parser(Embedded(default_verbs()))
    parser.parse(_SENTENCES[0])
    return [_one_sentence(parser), _growth(parser), _long_text(parser)]


def _one_sentence(parser: Parser) -> Figure:
    times = sorted(median_ms(partial(parser.parse, s), repeats=_REPEATS) for s in _SENTENCES)
    value = times[len(times) // 2]
    config = LanguageConfig()
    found = installed(config)
    if found is None:
        return Figure(name="a sentence, median", value=value, unit="ms")
    ace = Ace(found, config)
    peer = Parser(ace)
    peers = sorted(median_ms(partial(peer.parse, s), repeats=3) for s in _SENTENCES)
    ace.close()
    return Figure(
        name="a sentence, median", value=value, unit="ms", peer="ace",
        peer_value=peers[len(peers) // 2],
    )  # fmt: skip


def _growth(parser: Parser) -> Figure:
    """Compare the time a word takes in 62 words with that in 14: linear is 1."""
    per_word = []
    for count in (_LONG, _SHORT):
        sentence = (_CLAUSE * count).removesuffix(" and ")
        words = len(sentence.split())
        per_word.append(median_ms(partial(parser.parse, sentence), repeats=_REPEATS) / words)
    return Figure(
        name="a word of a long sentence", value=per_word[0], unit="ms", peer="of a short one",
        peer_value=per_word[1],
    )  # fmt: skip


def _long_text(parser: Parser) -> Figure:
    text = ("pick up the red cube. put it on the blue block. " * 220)[:10_000]
    start = process_time_ns()
    parser.parse(text)
    return Figure(name="10 000 characters", value=(process_time_ns() - start) / 1e9, unit="s")
