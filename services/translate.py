"""From the records of mapping to those of grounding: the two packages never meet elsewhere."""

from collections.abc import Iterable, Sequence

from gazemap.types.fixation import Fixation3D
from gazemap.types.scene import SceneObject
from gazemap.types.session import Cue
from grounding.language.parser import ParseResult
from grounding.types import FixationObservation, ObjectInstance, RestingPlace, SpokenInstruction


def observation(fixation: Fixation3D) -> FixationObservation:
    """Return a 3D fixation as grounding sees it."""
    return FixationObservation(
        fixation_id=fixation.fixation.fixation_id,
        start_ns=fixation.fixation.start_ns,
        end_ns=fixation.fixation.end_ns,
        point_world=fixation.point_world,
        cov_world=fixation.cov_world,
        origin_world=fixation.origin_world,
    )


def instance(thing: SceneObject) -> ObjectInstance:
    """Return an object with its resting places as grounding sees it."""
    track = tuple(
        RestingPlace(
            t_ns=state.t_ns,
            left_ns=state.left_ns,
            position_world=state.T_world_body.t,
            quat_xyzw=state.T_world_body.quat_xyzw,
            cov_world=state.cov_world,
        )
        for state in thing.track
    )
    return ObjectInstance(object_id=thing.object_id, size_m=thing.size_m, track=track)


def spoken_instructions(
    cues: Sequence[Cue], parses: Iterable[ParseResult], *, with_times: bool
) -> tuple[SpokenInstruction, ...]:
    """Return the instructions of a discourse in order, numbered through the whole session.

    Args:
        cues: what was said, one for each parse.
        parses: what the parser made of each cue.
        with_times: whether the transcript's times are passed on.
    """
    spoken: list[SpokenInstruction] = []
    for cue, parse in zip(cues, parses, strict=True):
        spoken.extend(
            SpokenInstruction(
                index=len(spoken) + k,
                sentence=parse.sentence,
                instruction=each,
                said_start_ns=cue.start_ns if with_times else None,
                said_end_ns=cue.end_ns if with_times else None,
            )
            for k, each in enumerate(parse.instructions)
        )
    return tuple(spoken)
