"""Sentences with their plans, as the files in tests/data/language hold them."""

from dataclasses import dataclass
from pathlib import Path

from grounding.language.parser import ParseResult
from grounding.types import Instruction

DATA = Path(__file__).parent / "data" / "language"

# How each kind of refusal is told by what the user reads.
REFUSALS = {
    "negated": "negated command",
    "statement": "states a fact",
    "question": "asks something",
    "no object": "has no object",
    "unknown verb": "is not known; teach it",
    "no antecedent": "nothing earlier",
    "choice": "leaves a choice",
    "empty": "nothing was said",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Planned:
    """A sentence with what it should give: a plan in the notation of the files."""

    sentence: str
    plan: str

    def is_met_by(self, result: ParseResult) -> bool:
        """Whether a parse is right."""
        if not self.plan.startswith("error"):
            return result.error is None and written(result.instructions) == self.plan
        kind = self.plan.removeprefix("error").strip()
        refused = result.error is not None and result.instructions == ()
        return refused and (not kind or REFUSALS[kind] in str(result.error))


def read_plans(name: str) -> list[Planned]:
    """Return the sentences of a file with their plans."""
    rows = [line.split(" => ") for line in (DATA / name).read_text().split("\n") if " => " in line]
    return [Planned(sentence=s, plan=p) for s, p in rows if not s.startswith("#")]


def all_plans() -> list[Planned]:
    """Return the sentences of every file that says what our own grammar should give."""
    names = ["plans.txt", *sorted(path.name for path in DATA.glob("unseen_*.txt"))]
    return [planned for name in names for planned in read_plans(name)]


def written(instructions: tuple[Instruction, ...]) -> str:
    """Return instructions in the notation of the files."""
    return " ; ".join(_one(each) for each in instructions)


def _one(each: Instruction) -> str:
    text = f"{each.action} {'-'.join(each.target)}"
    if not each.has_own_location:
        text += f" @ {each.location}"
    return text + (f" ~ {each.target_relation}" if each.target_relation else "")
