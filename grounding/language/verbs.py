"""The table that maps verbs to actions: data that a user extends by configuration or teaching."""

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from importlib.resources import files

from grounding.errors import ConfigError
from grounding.types import Action


class Frame(StrEnum):
    """How the prepositional phrases of a verb attach; see `data/verbs.toml`."""

    TAKE = "take"
    PLACE = "place"
    SHOW = "show"


@dataclass(frozen=True, slots=True, kw_only=True)
class VerbEntry:
    """What a verb does.

    Attributes:
        action: the action it maps to.
        frame: how its phrases attach.
        not_with: particles that make another verb of it.
    """

    action: Action
    frame: Frame
    not_with: frozenset[str]


@dataclass(frozen=True, slots=True, kw_only=True)
class VerbTable:
    """Verb lemma -> what it does; a lemma may have a particle behind it: "turn on"."""

    entries: Mapping[str, VerbEntry]

    def entry(self, verb: str, *, particle: str = "") -> VerbEntry | None:
        """Return what a verb does with a particle, or None for one that is not in the table."""
        exact = self.entries.get(f"{verb} {particle}")
        if exact is not None:
            return exact
        found = self.entries.get(verb)
        return None if found is not None and particle in found.not_with else found

    def taught(self, verb: str, *, like: str) -> "VerbTable":
        """Return a table that also knows `verb`, which does what `like` does.

        Raises:
            ConfigError: if `like` is not in the table either.
        """
        word, model = " ".join(verb.lower().split()), like.strip().lower()
        if not 1 <= len(word.split()) <= 2 or not word.replace(" ", "").isalpha():
            raise ConfigError(f'verb "{verb}": a word of letters is wanted, or two ("turn on")')
        if model not in self.entries:
            known = ", ".join(sorted(self.entries))
            raise ConfigError(f'verb "{verb}": "{like}" is not known either; choose one of {known}')
        return VerbTable(entries={**self.entries, word: self.entries[model]})


def teaching_hint(verb: str) -> str:
    """Return how a user teaches a verb that is not in the table."""
    return (
        f'the verb "{verb}" is not known; teach it with one it resembles: '
        f'--verb "{verb}=take", or "{verb}" = "take" under [verbs] in the configuration'
    )


@cache
def default_verbs() -> VerbTable:
    """Return the table that comes with the package."""
    text = files("grounding.language.data").joinpath("verbs.toml").read_text()
    entries = {
        word: VerbEntry(
            action=Action(group["action"]),
            frame=Frame(group["frame"]),
            not_with=frozenset(group.get("not_with", ())),
        )
        for group in tomllib.loads(text)["verbs"]
        for word in group["words"]
    }
    return VerbTable(entries=entries)


def with_taught(table: VerbTable, *, pairs: Iterable[tuple[str, str]]) -> VerbTable:
    """Return a table that knows each (verb, like) pair, in order, too."""
    for verb, like in pairs:
        table = table.taught(verb, like=like)
    return table
