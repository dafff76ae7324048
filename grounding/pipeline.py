"""The story of grounding one session."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from grounding.glide.align import align
from grounding.glide.config import GlideConfig
from grounding.glide.model import Demonstration
from grounding.glide.read import LookBelief
from grounding.plan import GroundedPlan, PlanConfig, Unparsed, ground_instructions


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundingConfig:
    """All stages of grounding a session."""

    glide: GlideConfig = field(default_factory=GlideConfig)
    plan: PlanConfig = field(default_factory=PlanConfig)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SessionGrounding:
    """Everything that grounding says of a session.

    Attributes:
        plan: the grounded plan.
        looks: one label for each fixation, in time order.
    """

    plan: GroundedPlan
    looks: tuple[LookBelief, ...]


def ground_session(
    demonstration: Demonstration,
    config: GroundingConfig | None = None,
    *,
    name: str,
    scale: str = "metric",
    unparsed: Sequence[Unparsed] = (),
) -> SessionGrounding:
    """Ground the instructions of one session.

    Args:
        demonstration: what was said, looked at and seen.
        config: of all stages; the defaults if None.
        name: of the session.
        scale: "metric" or "arbitrary".
        unparsed: sentences that gave no instruction.

    Returns:
        The plan and the labels of the fixations.
    """
    config = config or GroundingConfig()
    alignment = align(demonstration, config.glide)
    instructions = ground_instructions(demonstration.spoken, alignment, config.plan)
    plan = GroundedPlan(
        session=name,
        revision=1,
        scale=scale,
        instructions=instructions,
        unparsed=tuple(unparsed),
    )
    return SessionGrounding(plan=plan, looks=alignment.looks)
