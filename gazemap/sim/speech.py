"""What the person says, and when."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from gazemap.sim.config import PersonConfig
from gazemap.sim.vocabulary import PICK_VERBS, PUT_VERBS, Relation

if TYPE_CHECKING:
    from gazemap.sim.tabletop import Step

_NOW_SHARE = 0.2
_PRONOUN_SHARE = 0.5
_SENTENCE_S, _SHORTEST_S = 1.6, 0.8


@dataclass(frozen=True, slots=True, kw_only=True)
class Utterance:
    """A sentence and when it is said, from the first frame on."""

    start_s: float
    end_s: float
    text: str


def pick_sentence(words: tuple[str, str], rng: np.random.Generator) -> str:
    """Return a sentence that asks for a thing called by its colour and shape."""
    return _opened(f"{_one_of(PICK_VERBS, rng)} the {' '.join(words)}", rng)


def put_sentence(
    words: tuple[str, str],
    relation: Relation,
    *,
    reference: tuple[str, str],
    rng: np.random.Generator,
) -> str:
    """Return a sentence that places the thing just picked beside or on a reference."""
    thing = "it" if rng.random() < _PRONOUN_SHARE else f"the {' '.join(words)}"
    verb = _one_of(PUT_VERBS, rng)
    return _opened(f"{verb} {thing} {relation.phrase} the {' '.join(reference)}", rng)


def speak(
    steps: "tuple[Step, ...]", config: PersonConfig, rng: np.random.Generator
) -> tuple[Utterance, ...]:
    """Return one sentence a step, said as the step starts, give or take."""
    said: list[Utterance] = []
    for step in steps:
        delay_s = rng.normal(config.speech_delay_s, config.speech_sigma_s)
        start_s = max(float(step.start_s + delay_s), 0.0)
        if said:  # one sentence ends before the next begins
            start_s = max(start_s, said[-1].start_s + _SHORTEST_S)
            said[-1] = replace(said[-1], end_s=min(said[-1].end_s, start_s))
        end_s = max(step.start_s + _SENTENCE_S, start_s + _SHORTEST_S)
        said.append(Utterance(start_s=start_s, end_s=end_s, text=step.sentence))
    return tuple(said)


def _opened(sentence: str, rng: np.random.Generator) -> str:
    return f"now {sentence}" if rng.random() < _NOW_SHARE else sentence


def _one_of(words: tuple[str, ...], rng: np.random.Generator) -> str:
    return words[int(rng.integers(len(words)))]
