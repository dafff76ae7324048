"""Behind a noun: relative clauses, participles and adjectives with a complement."""

from collections.abc import Iterator
from typing import Final

from grounding.language.grammar.chart import Chart, Found
from grounding.language.grammar.modifiers import COLOURING, adjective_at, is_adjective
from grounding.language.grammar.rules import (
    adjective_phrase,
    gerund_predicate,
    relative,
    simple_noun,
    single_prep_phrase,
)
from grounding.language.grammar.tree import (
    Adjective,
    AdjectivePair,
    Kind,
    NounPhrase,
    PrepPhrase,
    VerbRelative,
    Word,
)
from grounding.language.morphology import Degree, Form

Attribute = Adjective | AdjectivePair | PrepPhrase | VerbRelative
Attributes = tuple[Attribute, ...]

_QUALITIES: Final = frozenset({"color", "colour", "shape", "size"})
_RELATIVE: Final = frozenset({"that", "which", "who", "whom"})
_SUBJECTS: Final = frozenset({"i", "you", "we", "he", "she", "they"})
_WITH_PHRASE: Final = frozenset(
    {"close", "near", "far", "full", "adjacent", "opposite", "similar", "parallel", "identical",
     "empty", "next", "nearest"}
)  # fmt: skip
_COMPLEMENTS: Final = frozenset({"to", "from", "of", "than"})
_WHEN_OR_HOW: Final = frozenset(
    {"best", "most", "least", "yesterday", "today", "earlier", "before", "recently", "again"}
)  # fmt: skip
_FINITE: Final = (Form.PRESENT, Form.PAST, Form.BASE)
_SKIPPED: Final = frozenset(
    {"have", "has", "had", "did", "do", "just", "are", "were", "was", "am", "is", "can", "could",
     "will", "would", "may", "might", "should", "must"}
)  # fmt: skip


@relative.define
def _relative(chart: Chart, i: int) -> Found[Attributes]:
    j = i + 1 if chart.at(i).text == "," and chart.at(i + 1).text in ("which", "who") else i
    if chart.at(j).text in _RELATIVE:
        yield from _with_copula(chart, j + 1)
        yield from _with_have(chart, j + 1)
        yield from _with_subject(chart, j + 1)
        yield from _with_verb(chart, j + 1)
    elif chart.at(j).text == "whose":
        yield from _whose(chart, j + 1)
    else:
        if chart.at(j).text in _SUBJECTS:
            yield from _with_subject(chart, j)
        elif chart.at(j).text == "the":
            yield from _with_named_subject(chart, j)
        yield from _with_have(chart, j)
        yield from _reduced(chart, j)


def _whose(chart: Chart, i: int) -> Found[Attributes]:
    """Yield "whose colour is red"; what is said of a part ("whose lid is red") is left out."""
    for part, j in simple_noun(chart, i):
        for attributes, end in _with_copula(chart, j):
            yield (attributes if part.head.lemma in _QUALITIES else ()), end


def _with_copula(chart: Chart, i: int) -> Found[Attributes]:
    """Yield what follows "which is": adjectives, a phrase, or a participle, or two of them."""
    token = chart.at(i)
    if not any(lemma in chart.words.closed["copulas"] for lemma, _ in token.verbs) and (
        token.text != "'s"
    ):
        return
    j = i + 1
    while chart.at(j).is_a("adverbs") and not is_adjective(chart.at(j)):
        j += 1
    for first, end in _predicative(chart, j):
        if chart.at(end).text == "and":
            for second, after in _predicative(chart, end + 1):
                yield (*first, *second), after
        yield first, end


def _predicative(chart: Chart, i: int) -> Found[Attributes]:
    for adjective, end in adjective_phrase(chart, i):
        yield (adjective,), end
    for phrase, end in single_prep_phrase(chart, i):
        yield (phrase,), end
    yield from _reduced(chart, i)
    for noun, end in simple_noun(chart, i):
        if noun.kind is Kind.ONE:
            yield tuple(m for m in noun.modifiers if isinstance(m, Adjective)), end


@adjective_phrase.define
def _adjective_phrase(chart: Chart, i: int) -> Found[Adjective | AdjectivePair]:
    for first, end in _one_adjective(chart, i):
        j = end
        while chart.at(j).text in (",", "and"):
            j += 1
        if j > end:
            for second, after in adjective_phrase(chart, j):
                word = chart.word(j - 1)
                yield AdjectivePair(conjunction=word, left=first, right=second), after
        yield first, end


def _one_adjective(chart: Chart, i: int) -> Found[Adjective]:
    negation = chart.word(i) if chart.at(i).text in ("not", "never") else None
    j = i + (negation is not None)
    while chart.at(j).text in ("the", "a", "most", "least", "more", "very", "really", "quite"):
        j += 1
    if chart.at(j).text in COLOURING and is_adjective(chart.at(j + 1)):
        j += 1
    token = chart.at(j)
    ordinal = token.is_a("ordinals") and j > i
    if not (is_adjective(token) or ordinal) or token.is_a("junk") or not token.text:
        return
    adjective = adjective_at(chart, j)
    for phrase, end in _complement(chart, j):
        yield _completed(adjective, phrase=phrase, negation=negation), end
    yield _completed(adjective, phrase=None, negation=negation), j + 1


def _completed(
    adjective: Adjective, *, phrase: PrepPhrase | None, negation: Word | None
) -> Adjective:
    return Adjective(
        word=adjective.word, degree=adjective.degree, intensifier=adjective.intensifier,
        phrase=phrase, negation=negation,
    )  # fmt: skip


def _complement(chart: Chart, i: int) -> Found[PrepPhrase]:
    """Yield what the adjective at `i` takes along: "to the box", "than the cup"."""
    token, following = chart.at(i), chart.at(i + 1)
    graded = token.degree is not Degree.POSITIVE or chart.at(i - 1).text in ("most", "more")
    if not (graded or token.adjective in _WITH_PHRASE):
        return
    if following.text in _COMPLEMENTS:
        for noun, end in simple_noun(chart, i + 2):
            yield PrepPhrase(word=chart.word(i + 1), landmark=noun), end
    elif token.text == "nearest" and following.is_a("determiners"):
        for noun, end in simple_noun(chart, i + 1):
            yield PrepPhrase(word=chart.word(i, lemma="to"), landmark=noun), end


def _with_subject(chart: Chart, i: int) -> Found[Attributes]:
    """Yield "I put on the tray": an object relative with a subject of its own."""
    explicit = chart.at(i - 1).text in _RELATIVE
    for subject, j in simple_noun(chart, i):
        pronoun = subject.kind is Kind.PRONOUN
        if not pronoun and not (explicit and subject.determiner is not None):
            continue
        k = j
        while chart.at(k).text in _SKIPPED or chart.at(k).is_a("adverbs"):
            k += 1
        verb = _verb(chart, k, forms=(*_FINITE, Form.PARTICIPLE, Form.GERUND))
        if verb is not None:
            yield from _verb_relative(chart, verb, i=k + 1, subject=subject)


def _with_named_subject(chart: Chart, i: int) -> Found[Attributes]:
    """Yield "the robot dropped" of "the cube the robot dropped": its verb must be in the past."""
    for subject, j in simple_noun(chart, i):
        token = chart.at(j)
        verb = _verb(chart, j, forms=(Form.PAST,)) if token.verb(Form.PAST) else None
        if verb is not None and not token.verb(Form.BASE) and not subject.after:
            yield from _verb_relative(chart, verb, i=j + 1, subject=subject)


def _with_have(chart: Chart, i: int) -> Found[Attributes]:
    """Yield "has a red lid" first without the phrase behind it, which is the verb's before."""
    if not any(lemma == "have" for lemma, _ in chart.at(i).verbs):
        return
    for part, end in simple_noun(chart, i + 1):
        clause = VerbRelative(
            verb=chart.word(i, lemma="have"), particle=None, subject=None, phrases=(),
            passive=False, object=part,
        )  # fmt: skip
        yield (clause,), end


def _with_verb(chart: Chart, i: int) -> Found[Attributes]:
    verb = _verb(chart, i, forms=_FINITE)
    if verb is not None:
        yield from _verb_relative(chart, verb, i=i + 1, subject=None, has_object=True)


def _reduced(chart: Chart, i: int) -> Found[Attributes]:
    """Yield "lying on the table", "made of wood", "closest to the box", "painted red"."""
    token = chart.at(i)
    if token.adjective or token.text in COLOURING:
        yield from _postnominal(chart, i)
    passive = bool(token.verb(Form.PARTICIPLE)) and not (
        token.verb(Form.BASE) or token.is_a("places")
    )
    if passive or token.verb(Form.GERUND):
        form = Form.PARTICIPLE if passive else Form.GERUND
        verb = _verb(chart, i, forms=(form,))
        if verb is not None:
            for found, end in _verb_relative(
                chart, verb, i=i + 1, subject=None, has_object=True, passive=passive
            ):
                if end > i + 1:
                    yield found, end


def _postnominal(chart: Chart, i: int) -> Found[Attributes]:
    painted = chart.at(i).text in COLOURING
    if painted and chart.at(i + 1).adjective:
        yield (adjective_at(chart, i + 1),), i + 2
    elif not painted and (chart.at(i).degree is not Degree.POSITIVE or chart.at(i).text == "full"):
        for phrase, end in _complement(chart, i):
            adjective = adjective_at(chart, i)
            yield (_completed(adjective, phrase=phrase, negation=None),), end


def _verb(chart: Chart, i: int, *, forms: tuple[Form, ...]) -> Word | None:
    token = chart.at(i)
    lemma = next((token.verb(form) for form in forms if token.verb(form)), "")
    if not lemma and not token.known and Form.PAST in forms:
        lemma = token.text
    return chart.word(i, lemma=lemma, known=token.known) if lemma else None


def _verb_relative(
    chart: Chart, verb: Word, *, i: int, subject: NounPhrase | None,
    has_object: bool = False, passive: bool = False,
) -> Found[Attributes]:  # fmt: skip
    for taken, j in _objects(chart, i, has_object=has_object, pronouns=subject is not None):
        particle = chart.word(j) if _is_particle(chart, j) else None
        for phrases, end in _phrases(chart, j + (particle is not None)):
            clause = VerbRelative(
                verb=verb, particle=particle, subject=subject, phrases=phrases, passive=passive,
                object=taken,
            )  # fmt: skip
            yield (clause,), end


def _objects(
    chart: Chart, i: int, *, has_object: bool, pronouns: bool
) -> Iterator[tuple[NounPhrase | None, int]]:
    """Yield what the verb of a clause takes; beside its subject only whom: "I gave you"."""
    for noun, end in simple_noun(chart, i) if has_object or pronouns else ():
        if has_object or noun.kind is Kind.PRONOUN:
            yield noun, end
    yield None, i


def _is_particle(chart: Chart, i: int) -> bool:
    following = chart.at(i + 1)
    opens = following.is_a("determiners") or following.noun
    return chart.at(i).is_a("particles") and not opens and following.text != "of"


def _phrases(chart: Chart, i: int) -> Found[tuple[PrepPhrase, ...]]:
    """Yield the one phrase of a relative clause, "of wood" included, or none."""
    if chart.at(i).text == "for":
        for _, end in sorted(gerund_predicate(chart, i + 1), key=lambda found: found[1]):
            yield (), end
    if chart.at(i).text == "of":
        for noun, end in simple_noun(chart, i + 1):
            yield (PrepPhrase(word=chart.word(i), landmark=noun),), end
    for phrase, end in single_prep_phrase(chart, i):
        yield (phrase,), end
    yield (), i + (chart.at(i).text in _WHEN_OR_HOW)
