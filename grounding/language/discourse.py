"""Pronouns over the sentences of a discourse: what "it", "them" and "the red one" stand for."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Final

from grounding.language.drafts import (
    Draft,
    Mention,
    Phrase,
    Reason,
    Reference,
    Refusal,
    refusal,
)
from grounding.language.lexicon import lexicon
from grounding.types import Action, Instruction

_OPENING: Final = (Action.OPEN, Action.CLOSE)


class Role(StrEnum):
    """What something was named as, which tells what may stand for it."""

    OBJECT = "object"  # of a verb: any pronoun
    LANDMARK = "landmark"  # "it" of what is opened and closed; "the red one"
    DENIED = "denied"  # object of a denied verb: only "the red one"


@dataclass(frozen=True, slots=True, kw_only=True)
class Referent:
    """Something that was named.

    Attributes:
        mention: how, in full.
        instruction: index of the instruction whose target it is; None where it is of none.
        draft: number of the command it was named in.
        role: what it was named as.
    """

    mention: Mention
    instruction: int | None
    draft: int
    role: Role


@dataclass(frozen=True, slots=True, kw_only=True)
class _Resolved:
    mention: Mention
    source: int | None


@dataclass(slots=True, kw_only=True)
class Discourse:
    """What was named so far, in order.

    Attributes:
        referents: everything named.
        instructions: how many instructions there were.
        drafts: how many commands there were.
    """

    referents: list[Referent] = field(default_factory=list)
    instructions: int = 0
    drafts: int = 0

    def understand(self, drafts: Sequence[Draft]) -> list[Instruction] | Refusal:
        """Return the instructions of a sentence; a refusal leaves the discourse as it was."""
        before = (len(self.referents), self.instructions, self.drafts)
        told: dict[int, list[Instruction]] = {}
        for i in sorted(range(len(drafts)), key=lambda i: drafts[i].start):
            result = self._one(drafts[i])
            if isinstance(result, Refusal):
                del self.referents[before[0] :]
                self.instructions, self.drafts = before[1], before[2]
                return result
            told[i] = result
        return self._in_order_of_doing(told, first=before[1])

    def _in_order_of_doing(
        self, told: Mapping[int, Sequence[Instruction]], *, first: int
    ) -> list[Instruction]:
        """Return what was said in one order and is done in another, numbered as it is done.

        Args:
            told: number of the draft -> its instructions, in the order spoken.
            first: the index of the first of them.
        """
        if list(told) == sorted(told):
            return [each for found in told.values() for each in found]
        spoken = [(i, k) for i, found in told.items() for k in range(len(found))]
        number = {spoken.index(at) + first: first + n for n, at in enumerate(sorted(spoken))}
        self.referents = [
            each if each.instruction is None
            else replace(each, instruction=number.get(each.instruction, each.instruction))
            for each in self.referents
        ]  # fmt: skip
        return [
            each if each.resolved_from is None
            else replace(each, resolved_from=number.get(each.resolved_from, each.resolved_from))
            for _, found in sorted(told.items()) for each in found
        ]  # fmt: skip

    def _one(self, draft: Draft) -> list[Instruction] | Refusal:
        self._name(draft.background, role=Role.DENIED)
        self._name(draft.held, role=Role.OBJECT)
        targets: list[_Resolved] = []
        for one in draft.targets:
            named = [each.mention for each in targets]
            resolved = self._target(one, action=draft.action, own=named)
            if not resolved:
                return _unresolved(one)
            targets.extend(resolved)
        own = [each.mention for each in targets]
        location = self._symbol(draft.location, own=own)
        relation = self._symbol(draft.relation, own=own, itself=own[0])
        for symbol in (location, relation):
            if isinstance(symbol, Refusal):
                return symbol
        return self._told(draft, targets=targets, location=str(location), relation=str(relation))

    def _told(
        self, draft: Draft, *, targets: Sequence[_Resolved], location: str, relation: str
    ) -> list[Instruction]:
        instructions = []
        for each in targets:
            words = each.mention.words
            unknown = dict.fromkeys((*each.mention.unknown, *_unknown(draft)))
            instructions.append(
                Instruction(
                    action=draft.action,
                    target=words,
                    location=location or "-".join(words) + "-location",
                    target_relation=relation or None,
                    resolved_from=each.source,
                    unknown=tuple(unknown),
                )
            )
        self._remember(draft, targets=targets)
        return instructions

    def _remember(self, draft: Draft, *, targets: Sequence[_Resolved]) -> None:
        phrases = (*draft.relation, *draft.location)
        for phrase in phrases:
            self._name(_landmarks(phrase), role=Role.LANDMARK)
        for each in targets:
            self.referents.append(
                Referent(
                    mention=each.mention,
                    instruction=self.instructions,
                    draft=self.drafts,
                    role=Role.OBJECT,
                )
            )
            self.instructions += 1
        self.drafts += 1

    def _name(self, found: Iterable[Mention], *, role: Role) -> None:
        """Remember what was named, but is no target."""
        for each in found:
            if each.reference is Reference.NAMED and each.words:
                referent = Referent(mention=each, instruction=None, draft=self.drafts, role=role)
                self.referents.append(referent)

    def _target(self, one: Mention, *, action: Action, own: Sequence[Mention]) -> list[_Resolved]:
        """Return what a target stands for; nothing if nothing earlier fits."""
        if one.reference is Reference.NAMED:
            return [_Resolved(mention=one, source=None)]
        if one.reference is Reference.NOUN_MISSING:
            return self._with_noun(one, own=own)
        return self._pronoun(one, own=(), opening=action in _OPENING)

    def _pronoun(
        self, one: Mention, *, own: Sequence[Mention], opening: bool = False
    ) -> list[_Resolved]:
        if one.plural:
            return self._several(own=own)
        words = [mention.words for mention in own]
        earlier = reversed(self.referents)
        fitting = [
            each for each in earlier if not each.mention.plural and each.mention.words not in words
        ]
        if opening:
            openable = [
                each for each in fitting
                if each.mention.words[-1] in lexicon().openable and each.role is not Role.DENIED
            ]  # fmt: skip
            if openable:
                return [_resolved(openable[0])]
        return [_resolved(each) for each in fitting if each.role is Role.OBJECT][:1]

    def _several(self, *, own: Sequence[Mention]) -> list[_Resolved]:
        """Return the latest plural target, or those named together, or all that were named.

        With a single target they are it and where it was put: "put the cup on the saucer and
        bring them".
        """
        words = [mention.words for mention in own]
        targets = [
            each for each in self.referents
            if each.instruction is not None and each.mention.words not in words
        ]  # fmt: skip
        for last in reversed(targets):
            together = [each for each in targets if each.draft == last.draft]
            if last.mention.plural or len(together) > 1:
                return [_resolved(each) for each in together]
        distinct = {each.mention.words: each for each in targets}
        if len(distinct) > 1 or not targets:
            return [_resolved(each) for each in distinct.values()]
        beside = [
            each for each in self.referents
            if each.draft == targets[-1].draft and each.instruction is None
            and each.role is Role.LANDMARK
            and each.mention.words[-1] not in lexicon().closed["directions"]
        ]  # fmt: skip
        return [_resolved(each) for each in (targets[-1], *beside)] if beside else []

    def _with_noun(self, one: Mention, *, own: Sequence[Mention]) -> list[_Resolved]:
        """Return "the red one" with the noun of what was named last."""
        known = [
            *[
                Referent(mention=each, instruction=None, draft=self.drafts, role=Role.OBJECT)
                for each in reversed(own)
            ],
            *reversed(self.referents),
        ]
        lender = next((each for each in known if each.mention.words), None)
        if lender is None:
            return []
        noun = lender.mention.words[lender.mention.noun_at :] or lender.mention.words[-1:]
        words = (*one.words, *noun)
        mention = replace(one, words=words, noun_at=len(one.words), reference=Reference.NAMED)
        return [_Resolved(mention=mention, source=lender.instruction)]

    def _symbol(
        self, phrases: Sequence[Phrase], *, own: Sequence[Mention], itself: Mention | None = None
    ) -> str | Refusal:
        """Return the symbol of phrases, "" for none; a pronoun may stand for the thing `itself`."""
        words: list[str] = []
        for phrase in phrases:
            for part in phrase.parts:
                if isinstance(part, str):
                    words.append(part)
                    continue
                found = self._landmark(part, own=own)
                if not found and itself is not None:
                    found = [_Resolved(mention=itself, source=None)]
                if not found:
                    return _unresolved(part)
                words.append("-and-".join("-".join(each.mention.words) for each in found))
        return "-".join(word for word in words if word)

    def _landmark(self, one: Mention, *, own: Sequence[Mention]) -> list[_Resolved]:
        if one.reference is Reference.NAMED:
            return [_Resolved(mention=one, source=None)]
        if one.reference is Reference.NOUN_MISSING:
            return self._with_noun(one, own=own)
        return self._pronoun(one, own=own)


def _landmarks(phrase: Phrase) -> list[Mention]:
    """Return what a phrase names, what can be opened last: "the drawer of the cabinet"."""
    found = [part for part in phrase.parts if isinstance(part, Mention)]
    first = found[0].words[-1:] if found else ()
    return found[::-1] if first and first[0] in lexicon().openable else found


def _resolved(referent: Referent) -> _Resolved:
    return _Resolved(mention=referent.mention, source=referent.instruction)


def _unresolved(one: Mention) -> Refusal:
    text = one.text or "it"
    return refusal(
        Reason.NO_ANTECEDENT, message=f'"{text}": there is nothing earlier that it can stand for'
    )


def _unknown(draft: Draft) -> list[str]:
    return [
        word
        for phrase in (*draft.location, *draft.relation)
        for part in phrase.parts
        if isinstance(part, Mention)
        for word in part.unknown
    ]
