"""What a person teaches a running service, as the JSON of the query `teach`.

{"verb": "ponder", "like": "look"}                        a verb that resembles a known one
{"instruction": 3, "object": "object-2", "is_meant": true}   "yes, this one"; false: "not that one"
{"words": ["green"], "object": "object-4", "group": null}    words for a thing on the table
"""

from dataclasses import dataclass

from gazemap.errors import InputError
from gazemap.wire.streams import Stream
from services.wire.grounding import Document


@dataclass(frozen=True, slots=True, kw_only=True)
class VerbLesson:
    """A verb that is to be understood as another."""

    verb: str
    like: str


@dataclass(frozen=True, slots=True, kw_only=True)
class TargetLesson:
    """Whether an instruction is about an object."""

    instruction: int
    object_id: str
    is_meant: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class WordLesson:
    """Words for an object; `group` says what they describe where that cannot be told."""

    words: tuple[str, ...]
    object_id: str
    group: str | None


Lesson = VerbLesson | TargetLesson | WordLesson


def lesson_of(document: Document) -> Lesson:
    """Return what a document teaches.

    Raises:
        InputError: if it is none of the forms above.
    """
    match document:
        case {"verb": str(verb), "like": str(like)}:
            return VerbLesson(verb=verb, like=like)
        case {"instruction": int(index), "object": str(object_id), "is_meant": bool(is_meant)}:
            return TargetLesson(instruction=index, object_id=object_id, is_meant=is_meant)
        case {"words": [*words], "object": str(object_id)} if words:
            group = document.get("group")
            return WordLesson(
                words=tuple(str(word) for word in words),
                object_id=object_id,
                group=None if group is None else str(group),
            )
    raise InputError(
        f"a lesson expected, got {dict(document)!r:.80}",
        where=Stream.TEACH,
        todo="send verb and like, or instruction, object and is_meant, or words and object",
    )
