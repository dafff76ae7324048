"""The grounding stage of a rebuild: sentences, alignment, patches and what words mean."""

from collections.abc import Sequence
from dataclasses import dataclass

from gazemap.pipeline import Located, Looks
from gazemap.ports import Session
from gazemap.types.scene import SceneModel
from grounding.glide.model import Demonstration
from grounding.language.parser import ParseResult, default_parser
from grounding.patches.view import View
from grounding.pipeline import GroundingConfig, SessionGrounding, ground_session
from grounding.plan import Unparsed
from services.translate import instance, observation, spoken_instructions
from services.views import FixedView, HeadView, StandingCamera


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mapped:
    """A session with all that mapping made of it."""

    session: Session
    located: Located
    scene: SceneModel
    looks: Looks


def ground(
    mapped: Mapped, config: GroundingConfig, *, with_narration_times: bool
) -> SessionGrounding:
    """Ground a session that was mapped."""
    data = mapped.session.data
    parses = default_parser().parse_discourse([cue.text for cue in data.narration])
    spoken = spoken_instructions(data.narration, parses, with_times=with_narration_times)
    demonstration = Demonstration(
        spoken=spoken,
        fixations=[observation(each) for each in mapped.looks.fixations],
        objects=[instance(each) for each in mapped.scene.objects],
        heading_rad=data.wearer_heading_rad,
    )
    return ground_session(
        demonstration,
        config,
        name=data.name,
        scale=mapped.located.slam.trajectory.scale.value,
        unparsed=unparsed(parses),
        view=patch_view(mapped),
    )


def unparsed(parses: Sequence[ParseResult]) -> tuple[Unparsed, ...]:
    """Return the sentences that gave no instruction, with the reason."""
    return tuple(
        Unparsed(sentence=parse.sentence, reason=parse.error)
        for parse in parses
        if parse.error is not None
    )


def patch_view(mapped: Mapped) -> View | None:
    """Return the camera that patches are cut from: the overhead one where it is posed."""
    session, T_world_overhead = mapped.session, mapped.located.T_world_overhead
    if session.overhead_camera is not None and T_world_overhead is not None:
        camera = StandingCamera(camera=session.overhead_camera, T_world_cam=T_world_overhead)
        return FixedView(camera=camera, t_ns=session.overhead_t_ns, frames=session.overhead_frames)
    if len(mapped.located.slam.trajectory) == 0:
        return None
    return HeadView(session=session, slam=mapped.located.slam)
