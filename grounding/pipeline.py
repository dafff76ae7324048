"""The story of grounding one session."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from grounding.glide.align import Alignment
from grounding.glide.chance import beyond_chance
from grounding.glide.config import GlideConfig
from grounding.glide.follow import Follower
from grounding.glide.model import Demonstration
from grounding.glide.read import LookBelief
from grounding.glide.windows import align_session
from grounding.language.config import LanguageConfig
from grounding.patches.cut import PatchConfig, cut_patches
from grounding.patches.patch import Patch
from grounding.patches.showings import showings_of
from grounding.patches.view import View
from grounding.plan import GroundedPlan, PlanConfig, Unparsed, ground_instructions
from grounding.query import demonstrations_of
from grounding.relations import Demonstrated
from grounding.symbols.model import SymbolModel
from grounding.symbols.records import SymbolConfig
from grounding.symbols.session import learn_from_patches
from grounding.words import heed_words

METRIC: Final = "metric"
_LOOKING_DISTANCE_M: Final = 0.7


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundingConfig:
    """All stages of grounding a session."""

    glide: GlideConfig = field(default_factory=GlideConfig)
    plan: PlanConfig = field(default_factory=PlanConfig)
    patches: PatchConfig = field(default_factory=PatchConfig)
    symbols: SymbolConfig = field(default_factory=SymbolConfig)
    language: LanguageConfig = field(default_factory=LanguageConfig)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SessionGrounding:
    """Everything that grounding says of a session.

    Attributes:
        plan: the grounded plan.
        looks: one label for each fixation, in time order.
        patches: pictures of the targets, kept or not.
        symbols: what the targets' words mean, as far as the patches tell.
        relations: what was put beside what, to learn relations from.
    """

    plan: GroundedPlan
    looks: tuple[LookBelief, ...]
    patches: tuple[Patch, ...]
    symbols: SymbolModel
    relations: tuple[Demonstrated, ...] = ()


def ground_session(  # noqa: PLR0913  all that a session is, by name
    demonstration: Demonstration,
    config: GroundingConfig | None = None,
    *,
    name: str,
    scale: str = METRIC,
    unparsed: Sequence[Unparsed] = (),
    view: View | None = None,
    follower: Follower | None = None,
    before: GroundedPlan | None = None,
) -> SessionGrounding:
    """Ground the instructions of one session.

    Args:
        demonstration: what was said, looked at and seen.
        config: of all stages; the defaults if None.
        name: of the session.
        scale: "metric" or "arbitrary".
        unparsed: sentences that gave no instruction.
        view: the camera that patches are cut from; None for no patches.
        follower: of a session that goes on: its last instructions may not have been done yet.
        before: the plan of a moment ago, of a session that goes on.

    Returns:
        The plan, the labels of the fixations, the patches and what the words mean.
    """
    config = _scaled(config or GroundingConfig(), demonstration, scale=scale)
    if follower is None:
        alignment = align_session(demonstration, config.glide)
    else:
        alignment = follower.align(demonstration, config.glide)
    before = before if follower is not None else None
    was_believed = before is not None and before.has_grounded
    is_believed = _goes_together(
        demonstration,
        alignment,
        config.plan.for_kept if was_believed else config.plan,
        chance=None if follower is not None else config.glide,
    )
    instructions = ground_instructions(
        demonstration.spoken,
        alignment,
        config.plan,
        open_end=follower is not None,
        is_believed=is_believed,
        before=before,
    )
    plan = GroundedPlan(
        session=name,
        revision=1,
        scale=scale,
        instructions=instructions,
        unparsed=tuple(unparsed),
    )
    showings = showings_of(plan, demonstration.objects, demonstration.fixations, config.patches)
    patches = cut_patches(showings, view, config.patches) if view is not None else []
    if scale != METRIC:
        patches = [dataclasses.replace(p, mm_per_px=None, height_mm=None) for p in patches]
    symbols = learn_from_patches(patches, config.symbols)
    return SessionGrounding(
        plan=heed_words(with_patches(plan, patches), patches, symbols),
        looks=alignment.looks if is_believed else _unclaimed(alignment.looks),
        patches=tuple(patches),
        symbols=symbols,
        relations=demonstrations_of(
            demonstration.spoken, alignment.instructions, heading_rad=demonstration.heading_rad
        ),
    )


def _goes_together(
    demonstration: Demonstration,
    alignment: Alignment,
    limits: PlanConfig,
    *,
    chance: GlideConfig | None,
) -> bool:
    """Return whether the gaze belongs to the narration, as far as can be told.

    Args:
        demonstration: what was said, looked at and seen.
        alignment: what the looks say of it.
        limits: when that counts as enough.
        chance: to compare with looks in disorder, once the session is over; None before.
    """
    if chance is None or len(demonstration.spoken) < limits.told_by_chance:
        return alignment.fit >= limits.fit_of_few
    if alignment.fit < limits.fit:
        return False
    return beyond_chance(demonstration, chance) >= limits.beyond_chance


def _unclaimed(looks: Sequence[LookBelief]) -> tuple[LookBelief, ...]:
    """Return the looks of a gaze that does not go with the narration: they serve nothing said."""
    return tuple(dataclasses.replace(each, instruction=None) for each in looks)


def _scaled(
    config: GroundingConfig, demonstration: Demonstration, *, scale: str
) -> GroundingConfig:
    """Return the configuration with the constants of the model in the units of the world.

    Where the scale is arbitrary, a metre is guessed from how far away people look on a table.
    """
    far = [
        float(np.linalg.norm(each.point_world - each.origin_world))
        for each in demonstration.fixations
        if each.point_world is not None and each.origin_world is not None
    ]
    if scale == METRIC or not far:
        return config
    unit_m = float(np.median(far)) / _LOOKING_DISTANCE_M
    return dataclasses.replace(
        config,
        glide=dataclasses.replace(config.glide, scene_unit_m=unit_m),
        plan=dataclasses.replace(config.plan, sigma_m=config.plan.sigma_m * unit_m),
        patches=dataclasses.replace(
            config.patches, unseen_size_m=config.patches.unseen_size_m * unit_m
        ),
    )


def with_patches(plan: GroundedPlan, patches: Sequence[Patch]) -> GroundedPlan:
    """Name in each instruction the patches that were kept."""
    names: dict[int, list[str]] = {}
    for each in patches:
        if each.kept:
            names.setdefault(each.instruction, []).append(each.name)
    instructions = tuple(
        dataclasses.replace(each, patches=tuple(names.get(each.spoken.index, ())))
        for each in plan.instructions
    )
    return dataclasses.replace(plan, instructions=instructions)
