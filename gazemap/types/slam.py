"""What tracking and mapping a whole recording gives."""

from dataclasses import dataclass

from gazemap.geometry.arrays import FloatArray, ImageArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.types.session import LayoutTag
from gazemap.types.tracking import TrackingOutcome, Trajectory


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SparseMap:
    """Points that were seen from several keyframes, and who saw them.

    Attributes:
        points_world: (M, 3) metres where the scale is metric.
        colours: (M, 3) uint8 RGB.
        cov_world: (M, 3, 3) covariances.
        keyframe_t_ns: (K,) times of the keyframes, ascending; each has a pose in the trajectory.
        view_keyframe: (V,) index of the keyframe of each view.
        view_point: (V,) index of the point of each view.
        view_uv_px: (V, 2) on the distorted image.
    """

    points_world: FloatArray
    colours: ImageArray
    cov_world: FloatArray
    keyframe_t_ns: IntArray
    view_keyframe: IntArray
    view_point: IntArray
    view_uv_px: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SlamResult:
    """A recording's path and map.

    Attributes:
        trajectory: the tracked frames in world, with the scale metric or arbitrary.
        outcomes: one for each scene frame, in time order.
        map: the sparse map.
        camera: the head camera as used, with its read-out time where that was estimated.
        warnings: what the user should know, a sentence each.
        surveyed_tags: tags that were seen but are not in the layout, where the map has them;
            none where the scale is arbitrary.
    """

    trajectory: Trajectory
    outcomes: tuple[TrackingOutcome, ...]
    map: SparseMap
    camera: Camera
    warnings: tuple[str, ...] = ()
    surveyed_tags: tuple[LayoutTag, ...] = ()
