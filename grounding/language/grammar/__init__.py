"""Our own grammar for instruction English: a memoised top-down chart over tokens.

`tree` holds what it builds, `chart` how rules share their work, `rules` names the rules that
call one another; `nouns`, `coordination`, `modifiers`, `prepositions`, `verbs` and `clauses`
define them.
"""

import grounding.language.grammar.coordination
import grounding.language.grammar.nouns
import grounding.language.grammar.predicates
import grounding.language.grammar.prepositions
import grounding.language.grammar.relatives  # noqa: F401 - each defines its rules
