"""Align a plan with the looks of its demonstration: the entrance to GLIDE."""

import dataclasses
import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grounding.glide.config import GlideConfig, Inference
from grounding.glide.dirichlet import infer_sampled
from grounding.glide.exact import Beliefs, infer
from grounding.glide.learn import update
from grounding.glide.model import Demonstration, Parameters, Session, initial_parameters, session_of
from grounding.glide.read import InstructionBelief, LookBelief, Reader, read_labels
from grounding.glide.tables import Model, build
from grounding.types import FixationObservation

_log = logging.getLogger(__name__)
_COLLAPSED = 10.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Alignment:
    """What the looks say of the plan.

    Attributes:
        looks: one label for each fixation, in time order.
        instructions: one belief for each spoken instruction, in the order said.
        log_evidence: log likelihood of the looks over that of no plan at all.
        fit: share of the looks within actions that are at what the action is about.
        parameters: what was learnt from the session, or None where there was nothing to learn.
        effective_samples: of the Dirichlet inference; None for the exact one.
    """

    looks: tuple[LookBelief, ...]
    instructions: tuple[InstructionBelief, ...]
    log_evidence: float
    fit: float
    parameters: Parameters | None
    effective_samples: float | None = None


def align(
    demonstration: Demonstration,
    config: GlideConfig | None = None,
    *,
    open_end: bool = False,
    rng: np.random.Generator | None = None,
) -> Alignment:
    """Infer which look serves which instruction, and what each instruction is about.

    Args:
        demonstration: what was said, looked at and seen.
        config: the constants; the defaults if None.
        open_end: the session goes on, so the last instructions may not have been done yet.
        rng: the source of chance, for the Dirichlet inference alone; seeded by 0 if None.

    Returns:
        The alignment; without instructions or without looks nothing is labelled.
    """
    config = config or GlideConfig()
    fixations = sorted(demonstration.fixations, key=lambda f: (f.start_ns, f.fixation_id))
    if not demonstration.spoken or not fixations:
        return _nothing(demonstration, fixations)
    session = session_of(dataclasses.replace(demonstration, fixations=fixations), config)
    learnt = learn_session(session, config, open_end=open_end, rng=rng or np.random.default_rng(0))
    if learnt.effective_samples is not None and learnt.effective_samples < _COLLAPSED:
        _log.warning("Dirichlet samples collapsed: %.1f effective", learnt.effective_samples)
    labels = read_labels(session, learnt.beliefs, demonstration.spoken, fixations)
    reader = Reader(
        session=session,
        model=learnt.model,
        beliefs=learnt.beliefs,
        objects=demonstration.objects,
        fixations=fixations,
        config=config,
    )
    return Alignment(
        looks=labels,
        instructions=tuple(
            reader.instruction(each, i, labels) for i, each in enumerate(demonstration.spoken)
        ),
        log_evidence=learnt.beliefs.log_evidence,
        fit=float(learnt.beliefs.member.sum() / max(float(learnt.beliefs.inside.sum()), 1e-9)),
        parameters=learnt.parameters,
        effective_samples=learnt.effective_samples,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Learnt:
    """A session's parameters, the model with them, and the beliefs under it."""

    parameters: Parameters
    model: Model
    beliefs: Beliefs
    effective_samples: float | None


def learn_session(
    session: Session, config: GlideConfig, *, open_end: bool, rng: np.random.Generator
) -> Learnt:
    """Alternate inference and learning; end with the beliefs under what was learnt."""
    learnt = _infer(
        session, initial_parameters(session, config), config, open_end=open_end, rng=rng
    )
    for _ in range(config.rounds):
        parameters = update(session, learnt.parameters, learnt.beliefs, learnt.model, config)
        learnt = _infer(session, parameters, config, open_end=open_end, rng=rng)
    return learnt


def _infer(
    session: Session,
    parameters: Parameters,
    config: GlideConfig,
    *,
    open_end: bool,
    rng: np.random.Generator,
) -> Learnt:
    model = build(session, parameters, config, open_end=open_end)
    if config.inference is Inference.DIRICHLET:
        sampled = infer_sampled(session, model, parameters, config, rng=rng)
        beliefs, effective = sampled.beliefs, sampled.effective_samples
    else:
        beliefs, effective = infer(session, model), None
    return Learnt(parameters=parameters, model=model, beliefs=beliefs, effective_samples=effective)


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
                landmark=None,
                over=0.0,
                fixation_ids=(),
            )
            for each in demonstration.spoken
        ),
        log_evidence=0.0,
        fit=0.0,
        parameters=None,
    )
