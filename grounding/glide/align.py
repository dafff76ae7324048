"""Align a plan with the looks of its demonstration: the entrance to GLIDE."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

from grounding.glide.config import GlideConfig
from grounding.glide.exact import Beliefs, infer
from grounding.glide.learn import update
from grounding.glide.model import Demonstration, Parameters, Session, initial_parameters, session_of
from grounding.glide.read import InstructionBelief, LookBelief, Reader, read_labels
from grounding.glide.tables import Model, build
from grounding.types import FixationObservation


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Alignment:
    """What the looks say of the plan.

    Attributes:
        looks: one label for each fixation, in time order.
        instructions: one belief for each spoken instruction, in the order said.
        log_evidence: log likelihood of the looks over that of no plan at all.
        parameters: what was learnt from the session, or None where there was nothing to learn.
    """

    looks: tuple[LookBelief, ...]
    instructions: tuple[InstructionBelief, ...]
    log_evidence: float
    parameters: Parameters | None


def align(
    demonstration: Demonstration, config: GlideConfig | None = None, *, open_end: bool = False
) -> Alignment:
    """Infer which look serves which instruction, and what each instruction is about.

    Args:
        demonstration: what was said, looked at and seen.
        config: the constants; the defaults if None.
        open_end: the session goes on, so the last instructions may not have been done yet.

    Returns:
        The alignment; without instructions or without looks nothing is labelled.
    """
    config = config or GlideConfig()
    fixations = sorted(demonstration.fixations, key=lambda f: (f.start_ns, f.fixation_id))
    if not demonstration.spoken or not fixations:
        return _nothing(demonstration, fixations)
    session = session_of(dataclasses.replace(demonstration, fixations=fixations), config)
    parameters, model, beliefs = learn_session(session, config, open_end=open_end)
    labels = read_labels(session, beliefs, demonstration.spoken, fixations)
    reader = Reader(
        session=session,
        model=model,
        beliefs=beliefs,
        objects=demonstration.objects,
        fixations=fixations,
        config=config,
    )
    return Alignment(
        looks=labels,
        instructions=tuple(
            reader.instruction(each, i, labels) for i, each in enumerate(demonstration.spoken)
        ),
        log_evidence=beliefs.log_evidence,
        parameters=parameters,
    )


def learn_session(
    session: Session, config: GlideConfig, *, open_end: bool = False
) -> tuple[Parameters, Model, Beliefs]:
    """Alternate exact inference and learning; end with the beliefs under what was learnt."""
    parameters = initial_parameters(session, config)
    model = build(session, parameters, config, open_end=open_end)
    beliefs = infer(session, model)
    for _ in range(config.rounds):
        parameters = update(session, parameters, beliefs, model, config)
        model = build(session, parameters, config, open_end=open_end)
        beliefs = infer(session, model)
    return parameters, model, beliefs


def _nothing(demonstration: Demonstration, fixations: Sequence[FixationObservation]) -> Alignment:
    return Alignment(
        looks=tuple(
            LookBelief(fixation_id=f.fixation_id, instruction=None, probability=1.0)
            for f in fixations
        ),
        instructions=tuple(
            InstructionBelief(
                index=each.index,
                start_ns=None,
                end_ns=None,
                done=0.0,
                looks=0.0,
                candidates=(),
                moves=False,
                location=None,
                fixation_ids=(),
            )
            for each in demonstration.spoken
        ),
        log_evidence=0.0,
        parameters=None,
    )
