"""Frozen records that are handed from stage to stage of grounding."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ImageArray = NDArray[np.uint8]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


class Action(StrEnum):
    """The closed set of actions that a verb table maps verbs to."""

    PICK = "pick"
    PLACE = "place"
    MOVE = "move"
    PUSH = "push"
    PULL = "pull"
    ROTATE = "rotate"
    OPEN = "open"
    CLOSE = "close"
    POUR = "pour"
    GIVE = "give"
    POINT = "point"


@dataclass(frozen=True, slots=True, kw_only=True)
class Instruction:
    """One `(action target location)` tuple of the abstract plan.

    Attributes:
        action: what is done.
        target: lower-case lemmas, adjectives in the order spoken, the noun last.
        location: hyphenated symbol, never empty; the target's own where none was said.
        target_relation: a phrase that describes the target, of the form of a location, or None.
        resolved_from: index, in the same discourse, of the instruction whose target a pronoun took.
        unknown: words the grammar did not know.
    """

    action: Action
    target: tuple[str, ...]
    location: str
    target_relation: str | None = None
    resolved_from: int | None = None
    unknown: tuple[str, ...] = ()

    @property
    def has_own_location(self) -> bool:
        """Whether no location was said."""
        return self.location == "-".join(self.target) + "-location"


@dataclass(frozen=True, slots=True, kw_only=True)
class SpokenInstruction:
    """An instruction with its place in the session; the times are the transcript's, or None."""

    index: int
    sentence: str
    instruction: Instruction
    said_start_ns: int | None
    said_end_ns: int | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FixationObservation:
    """A 3D fixation as grounding sees it.

    Attributes:
        fixation_id: id of the fixation.
        start_ns: its start.
        end_ns: its end.
        point_world: (3,) metres, or None where the gaze met nothing.
        cov_world: (3, 3) m^2, or None with the point.
        origin_world: (3,) where the gaze ray starts, or None where it is not known. A person looks
            at a thing's middle, the ray ends on its surface or, before a thing is put down, on
            what lies behind: with the origin the ray is compared, without it the point.
    """

    fixation_id: int
    start_ns: int
    end_ns: int
    point_world: FloatArray | None
    cov_world: FloatArray | None
    origin_world: FloatArray | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RestingPlace:
    """Where an object rested from t_ns until left_ns (None: to the end).

    Attributes:
        position_world: (3,) centre of its volume, metres.
        quat_xyzw: (4,) orientation.
        cov_world: (3, 3) covariance of the centre, m^2.
    """

    t_ns: int
    left_ns: int | None
    position_world: FloatArray
    quat_xyzw: FloatArray
    cov_world: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ObjectInstance:
    """A thing on the table, found by vision, without a name.

    Attributes:
        object_id: "object-N".
        size_m: (3,) extents of its box.
        track: its resting places in time order.
        colour_lab: (3,) its mean colour, CIELAB, or None.
    """

    object_id: str
    size_m: FloatArray
    track: tuple[RestingPlace, ...]
    colour_lab: FloatArray | None = None
