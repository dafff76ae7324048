"""Predicates of nouns and adjectives, with the senses that the ERG gives them."""

from grounding.language.grammar.tree import Word
from grounding.language.lexicon import lexicon


def noun_label(word: Word) -> str:
    """Return a noun's predicate; PyDelphin's PENMAN codec cannot read the ERG's "/nn_u_"."""
    sense = lexicon().senses.get(("noun", word.lemma), "1") if word.known else "unknown"
    return f"_{word.lemma}_n_{sense}"


def adjective_label(word: Word) -> str:
    """Return an adjective's predicate."""
    sense = lexicon().senses.get(("adjective", word.lemma), "1") if word.known else "unknown"
    return f"_{word.lemma}_a_{sense}"
