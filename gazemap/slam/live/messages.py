"""What tracking and mapping tell each other; every record can cross a process boundary."""

from dataclasses import dataclass
from pathlib import Path

from gazemap.geometry.arrays import FloatArray, ImageArray, IntArray
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.live.landmarks import Landmarks
from gazemap.types.map import MapEvent
from gazemap.types.tracking import Scale


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class KeyframeNote:
    """A frame that the map shall be built from.

    Attributes:
        keyframe_id: ascending.
        t_ns: exposure of the middle row.
        grey: (height, width).
        T_cam_world: its pose as it was published.
        twist: (6,) of `T_cam_world` from the left, a second.
        ids: (N,) the points that were measured.
        uv_px: (N, 2) where.
        sigma_px: (N,) how well.
        vanished_ids: (V,) points that were looked for often and hardly ever found.
        born_ids: (B,) corners that are new; this frame holds their reference.
        born_uv_px: (B, 2) even pixels.
        readout_s: of the camera's shutter, as far as it is known.
    """

    keyframe_id: int
    t_ns: int
    grey: ImageArray
    T_cam_world: Pose[Cam, World]
    twist: FloatArray
    ids: IntArray
    uv_px: FloatArray
    sigma_px: FloatArray
    vanished_ids: IntArray
    born_ids: IntArray
    born_uv_px: FloatArray
    readout_s: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StartNote:
    """The frames that a new map starts from, posed by the bootstrap; at least two."""

    map_id: int
    keyframes: tuple[KeyframeNote, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class SaveNote:
    """Write the map to a file."""

    path: Path


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadNote:
    """Go on in a map that was saved."""

    path: Path


Note = KeyframeNote | StartNote | SaveNote | LoadNote


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MapUpdate:
    """The map after a keyframe was worked in.

    Attributes:
        keyframe_id: that keyframe.
        T_cam_world: its pose now.
        landmarks: the points; `references` holds only those of `new_ids`, in their order.
        new_ids: (M,) the points that were no points of the map before.
        keyframe_centres_world: (K, 3).
        keyframe_axes_world: (K, 3) directions of view.
        keyframe_t_ns: (K,) their times.
        keyframe_poses: K poses.
        map_id: which map this is.
        scale: whether it is metric.
        events: what happened meanwhile.
    """

    keyframe_id: int
    T_cam_world: Pose[Cam, World]
    landmarks: Landmarks
    new_ids: IntArray
    keyframe_centres_world: FloatArray
    keyframe_axes_world: FloatArray
    keyframe_t_ns: IntArray
    keyframe_poses: tuple[Pose[World, Cam], ...]
    map_id: int
    scale: Scale
    events: tuple[MapEvent, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class StartRefused:
    """The frames did not make a map; the bootstrap goes on."""

    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Saved:
    """The map was written."""

    path: Path


@dataclass(frozen=True, slots=True, kw_only=True)
class Refused:
    """A file that cannot be used: the parts of an InputError, which crosses the process."""

    what: str
    where: str
    todo: str


Reply = MapUpdate | StartRefused | Saved | Refused
