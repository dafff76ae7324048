"""The rules that call one another, declared here and defined in the modules named."""

from grounding.language.grammar.chart import Rule
from grounding.language.grammar.tree import (
    Adjective,
    AdjectivePair,
    Nominal,
    NounPhrase,
    Predicate,
    PrepPhrase,
    Sentence,
    VerbRelative,
)

# nouns
simple_noun = Rule[NounPhrase]("simple noun phrase")
nominal = Rule[Nominal]("noun phrases with conjunctions")
# modifiers
adjective_phrase = Rule[Adjective | AdjectivePair]("predicative adjectives")
relative = Rule[tuple[Adjective | AdjectivePair | PrepPhrase | VerbRelative, ...]]("relative")
# prepositions
prep_phrase = Rule[PrepPhrase]("prepositional phrase")
single_prep_phrase = Rule[PrepPhrase]("prepositional phrase, its landmark without a conjunction")
# verbs
base_predicate = Rule[Predicate]("predicate in the base form")
finite_predicate = Rule[Predicate]("predicate in the present or past")
gerund_predicate = Rule[Predicate]("predicate in the gerund")
participle_predicate = Rule[Predicate]("predicate in the past participle")
single_base = Rule[Predicate]("one predicate in the base form")
single_finite = Rule[Predicate]("one predicate in the present or past")
single_gerund = Rule[Predicate]("one predicate in the gerund")
single_participle = Rule[Predicate]("one predicate in the past participle")
# clauses
clause = Rule[Sentence]("one clause")
