"""A parse as the JSON object that `gazemap parse` prints."""

from grounding.language.parser import ParseResult
from grounding.types import Instruction


def result_document(result: ParseResult) -> dict[str, object]:
    """Return the object of one line; `error` says why there is no instruction."""
    return {
        "sentence": result.sentence,
        "backend": result.backend,
        "error": result.error,
        "instructions": [_instruction(each) for each in result.instructions],
    }


def _instruction(each: Instruction) -> dict[str, object]:
    return {
        "action": each.action.value,
        "target": list(each.target),
        "location": each.location,
        "target_relation": each.target_relation,
        "resolved_from": each.resolved_from,
        "unknown": list(each.unknown),
    }
