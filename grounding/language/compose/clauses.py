"""The nodes of clauses and verbs."""

from typing import Final

from delphin.eds import EDS

from grounding.language.compose.nodes import Nodes
from grounding.language.compose.things import Things
from grounding.language.grammar.tree import (
    Adjective,
    AdjectivePair,
    Adverb,
    Clause,
    ClausePair,
    Control,
    Description,
    Fragment,
    Mood,
    Negation,
    Predicate,
    PredicatePair,
    PrepPhrase,
    Sentence,
    Subordination,
    VerbPhrase,
    Word,
)
from grounding.language.lexicon import lexicon

_ADVERBS: Final = {"now": "_now_a_2", "finally": "_final_a_1"}
_TENSED: Final = {"TENSE": "pres", "MOOD": "indicative", "PROG": "-", "PERF": "-"}


def compose(sentence: Sentence) -> EDS:
    """Return the EDS of a tree: one connected graph, its top the outermost event."""
    clauses = Clauses()
    return clauses.nodes.finished(top=clauses.sentence(sentence))


class Clauses:
    """Adds the nodes of clauses; each method returns the id of the main one."""

    def __init__(self) -> None:
        self.nodes = Nodes()
        self._things = Things(self.nodes)
        self._words = lexicon()

    def sentence(self, sentence: Sentence) -> str:
        """Add a sentence and return the node that stands for it."""
        match sentence:
            case ClausePair():
                left, right = self.sentence(sentence.left), self.sentence(sentence.right)
                return self._pair(sentence.conjunction, left=left, right=right)
            case Subordination(word=word):
                main, side = self.sentence(sentence.main), self.sentence(sentence.side)
                label = self._words.subordinators[word.lemma].predicate
                return self.nodes.event(label, at=word.span, edges={"ARG1": main, "ARG2": side})
            case Fragment(nominal=nominal):
                x = self._things.nominal(nominal)
                return self.nodes.event(
                    "unknown", at=(nominal.start, nominal.end), edges={"ARG": x}
                )
            case Description():
                return self._description(sentence)
            case Clause():
                return self._clause(sentence)

    def _pair(self, word: Word | None, *, left: str, right: str) -> str:
        edges = {"ARG1": left, "ARG2": right}
        if word is None:
            return self.nodes.event("implicit_conj", at=self.nodes.span_of(right), edges=edges)
        label = f"_{word.lemma.replace('&', 'and')}_c"
        return self.nodes.event(label, at=word.span, edges=edges)

    def _clause(self, clause: Clause) -> str:
        subject = None if clause.subject is None else self._things.nominal(clause.subject)
        event = self._predicate(clause.predicate, subject=subject, mood=clause.mood)
        for adverb in clause.adverbs:
            self._adverb(adverb, event=event, opening=True)
        return event

    def _description(self, description: Description) -> str:
        subject = self._things.nominal(description.subject)
        properties = {"SF": description.mood.value, **_TENSED}
        edges = {"ARG1": subject}
        match description.said:
            case Adjective() | AdjectivePair() as said:
                return self._things.attribute(said, of=subject, properties=properties)
            case PrepPhrase() as said:
                return self._things.phrase(said, of=subject, properties=properties)
            case None:
                pass
            case nominal:
                edges["ARG2"] = self._things.nominal(nominal)
        at = description.verb.span
        return self.nodes.event("_be_v_id", at=at, edges=edges, properties=properties)

    def _predicate(self, predicate: Predicate, *, subject: str | None, mood: Mood) -> str:
        """Add a predicate; without a subject each verb gets the silent one of a command."""
        match predicate:
            case PredicatePair():
                left = self._predicate(predicate.left, subject=subject, mood=mood)
                right = self._predicate(predicate.right, subject=subject, mood=mood)
                return self._pair(predicate.conjunction, left=left, right=right)
            case Negation():
                inner = self._predicate(predicate.body, subject=subject, mood=mood)
                return self._negation(predicate.word, of=inner)
            case Control():
                return self._control(predicate, subject=subject, mood=mood)
            case VerbPhrase():
                return self._verb(predicate, subject=subject, mood=mood)

    def _negation(self, word: Word, *, of: str) -> str:
        if word.lemma.endswith("not"):
            return self.nodes.event("neg", at=word.span, edges={"ARG1": of})
        if word.lemma.endswith("never"):
            return self.nodes.event("_never_a_1", at=word.span, edges={"ARG1": of})
        return self.nodes.event(f"_{word.lemma}_v_1", at=word.span, edges={"ARG2": of})

    def _control(self, control: Control, *, subject: str | None, mood: Mood) -> str:
        verb = control.verb
        below = Mood.STATEMENT if verb is not None and subject is not None else mood
        person = subject if control.person is None else self._things.nominal(control.person)
        inner = self._predicate(control.body, subject=person, mood=below)
        if verb is None:
            return inner
        properties = {"SF": mood.value, **_TENSED}
        if verb.lemma in ("go", "go+ahead", "come"):
            label = "_go_v_ahead" if verb.lemma == "go+ahead" else f"_{verb.lemma}_v_1"
            going = self.nodes.event(label, at=verb.span, edges={}, properties=properties)
            return self._pair(None, left=going, right=inner)
        if control.modal:
            label, edges = f"_{verb.lemma}_v_modal", {"ARG1": inner}
        else:
            label, edges = f"_{verb.lemma}_v_1", {"ARG2": inner}
            if subject is not None:
                edges["ARG1"] = subject
        return self.nodes.event(label, at=verb.span, edges=edges, properties=properties)

    def _verb(self, phrase: VerbPhrase, *, subject: str | None, mood: Mood) -> str:
        if subject is None and not phrase.passive:
            person = "1" if mood is Mood.STATEMENT else "2"
            at = (phrase.verb.start, phrase.end)
            subject = self._things.silent_subject(at=at, person=person)
        edges: dict[str, str] = {} if subject is None else {"ARG1": subject}
        if phrase.object is not None:
            edges["ARG2"] = self._things.nominal(phrase.object)
        if phrase.recipient is not None:
            edges["ARG3"] = self._things.nominal(phrase.recipient)
        label, properties = self._label(phrase), {"SF": mood.value, **_TENSED}
        event = self.nodes.event(label, at=phrase.verb.span, edges=edges, properties=properties)
        self._phrases(phrase, event=event, target=edges.get("ARG2"))
        particle = phrase.particle
        if particle is not None and not label.endswith(f"_{particle.lemma}"):
            edges = {"ARG1": event}
            self.nodes.event(f"_{particle.lemma}_p_state", at=particle.span, edges=edges)
        for adverb in phrase.adverbs:
            opening = adverb.word.start < phrase.verb.start and mood is Mood.COMMAND
            self._adverb(adverb, event=event, opening=opening)
        return event

    def _label(self, phrase: VerbPhrase) -> str:
        verb, particle = phrase.verb, phrase.particle
        if not verb.known:
            return f"_{verb.lemma}_v_unknown"
        if particle is not None:
            both, closed = f"{verb.lemma} {particle.lemma}", self._words.closed
            if both in closed["particle_sense"] or (
                phrase.joined and both in closed["joined_sense"]
            ):
                return f"_{verb.lemma}_v_{particle.lemma}"
        return f"_{verb.lemma}_v_{self._words.senses.get(('verb', verb.lemma), '1')}"

    def _phrases(self, phrase: VerbPhrase, *, event: str, target: str | None) -> None:
        """Hang each phrase where the ERG would: the third argument, the object, a landmark."""
        for each in phrase.fronted:
            self._things.phrase(each, of=event, event=True)
        third = phrase.verb.lemma in self._words.closed["third_argument"] and target is not None
        on_event = target is None or (not third and self.nodes.is_pronoun(target))
        head, is_event = (event if target is None or on_event else target), on_event
        added, before = "", (head, is_event)
        for i, each in enumerate(phrase.phrases):
            if each.joined is not None:
                head, is_event = before
            last, before = added, (head, is_event)
            added = self._things.phrase(each, of=head, event=is_event)
            if each.joined is not None:
                self._pair(each.joined, left=last, right=added)
            if i == 0 and third and phrase.recipient is None:
                self.nodes.connect(event, edges={"ARG3": added})
            if self._things.last_landmark is not None and each.negation is None:
                head, is_event = self._things.last_landmark, False

    def _adverb(self, adverb: Adverb, *, event: str, opening: bool) -> None:
        word, edges = adverb.word, {"ARG1": event}
        if word.lemma == "please" and opening:
            self.nodes.event("polite", at=word.span, edges=edges, carg="please")
        else:
            label = _ADVERBS.get(word.lemma, f"_{word.lemma}_a_1")
            self.nodes.event(label, at=word.span, edges=edges)
