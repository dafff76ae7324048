"""The grounding stage of a rebuild: sentences, alignment, patches and what words mean."""

from dataclasses import dataclass

from gazemap.pipeline import Located, Looks
from gazemap.ports import Session
from gazemap.types.scene import SceneModel
from gazemap.types.session import Cue
from grounding.discourse import Utterance, understand
from grounding.glide.model import Demonstration
from grounding.language.parser import parser_for
from grounding.patches.view import View
from grounding.pipeline import GroundingConfig, SessionGrounding, ground_session
from services.translate import instance, observation
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
    utterances = [_utterance(cue, with_times=with_narration_times) for cue in data.narration]
    discourse = understand(utterances, parser_for(config.language))
    demonstration = Demonstration(
        spoken=discourse.spoken,
        fixations=[observation(each) for each in mapped.looks.fixations],
        objects=[instance(each) for each in mapped.scene.objects],
        heading_rad=data.wearer_heading_rad,
    )
    return ground_session(
        demonstration,
        config,
        name=data.name,
        scale=mapped.located.slam.trajectory.scale.value,
        unparsed=discourse.unparsed,
        view=patch_view(mapped),
    )


def _utterance(cue: Cue, *, with_times: bool) -> Utterance:
    times = (cue.start_ns, cue.end_ns) if with_times else (None, None)
    return Utterance(text=cue.text, start_ns=times[0], end_ns=times[1])


def patch_view(mapped: Mapped) -> View | None:
    """Return the camera that patches are cut from: the overhead one where it is posed."""
    session, T_world_overhead = mapped.session, mapped.located.T_world_overhead
    if session.overhead_camera is not None and T_world_overhead is not None:
        camera = StandingCamera(camera=session.overhead_camera, T_world_cam=T_world_overhead)
        return FixedView(camera=camera, t_ns=session.overhead_t_ns, frames=session.overhead_frames)
    if len(mapped.located.slam.trajectory) == 0:
        return None
    return HeadView(session=session, slam=mapped.located.slam)
