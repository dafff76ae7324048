"""The default backend: our own grammar, no program and no network."""

from collections.abc import Sequence
from typing import Final

from delphin.eds import EDS

from grounding.language.compose.clauses import compose
from grounding.language.disfluency import fluent
from grounding.language.grammar.clauses import readings
from grounding.language.verbs import VerbTable
from grounding.language.words import tokens_of, verb_forms

MAX_TOKENS: Final = 120


class Embedded:
    """Parses with the grammar of `grounding.language.grammar`."""

    def __init__(self, verbs: VerbTable) -> None:
        self._verbs = verbs
        self._forms = verb_forms(verbs)

    @property
    def name(self) -> str:
        """What a parse says it came from."""
        return "embedded"

    def readings(self, sentence: str) -> Sequence[EDS]:
        """Return the readings of a sentence; none for one of more than `MAX_TOKENS` words."""
        tokens = fluent(tokens_of(sentence, forms=self._forms))
        if not tokens or len(tokens) > MAX_TOKENS:
            return []
        return [compose(tree) for tree in readings(tokens, verbs=self._verbs)]
