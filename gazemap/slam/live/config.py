"""What the live tracker can be told."""

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True, kw_only=True)
class FrontEndConfig:
    """Tracking of one frame.

    Attributes:
        flow_landmarks: points of the map that the optical flow follows.
        candidates: corners that are followed until they can be triangulated.
        aligned_landmarks: points of the map whose fixed patch is aligned in each frame.
        flow_window_px: side of the optical flow's window.
        flow_levels: pyramid levels above the full image.
        least_correlation: of an aligned patch.
        patch_sigma_px: standard deviation of an aligned patch.
        flow_sigma_px: standard deviation of the optical flow.
        least_inliers: with fewer the frame is lost.
        blank_contrast: a frame whose grey values spread less shows nothing.
    """

    flow_landmarks: int = 110
    candidates: int = 130
    aligned_landmarks: int = 220
    flow_window_px: int = 15
    flow_levels: int = 3
    least_correlation: float = 0.8
    patch_sigma_px: float = 0.3
    flow_sigma_px: float = 1.0
    least_inliers: int = 14
    blank_contrast: float = 4.0


@dataclass(frozen=True, slots=True, kw_only=True)
class BootstrapConfig:
    """The start without a map.

    Attributes:
        corners: that are followed.
        least_flow_px: median motion below which no geometry is tried.
        least_parallax_deg: median angle between the two rays of a point.
        wanted_parallax_px: upper quartile of the motion that a turn does not explain.
        least_parallax_px: with what a slow start is content after `patience_frames`.
        patience_frames: over which the wanted parallax falls to the least.
        longest_frames: after so many frames the start is tried anew.
    """

    corners: int = 400
    least_flow_px: float = 8.0
    least_parallax_deg: float = 0.5
    wanted_parallax_px: float = 8.0
    least_parallax_px: float = 2.0
    patience_frames: int = 18
    longest_frames: int = 60


@dataclass(frozen=True, slots=True, kw_only=True)
class MappingConfig:
    """Keyframes and the map.

    Attributes:
        keyframe_distance: moved path over depth, plus half the turn, from the nearest keyframe.
        keyframe_gap_frames: least number of frames between two keyframes.
        least_parallax_deg: of a new point.
        worst_error_px: of a new point's measurements.
        window: keyframes that a local adjustment may move.
        keyframes_kept: beyond these the most redundant one goes.
        full_every: keyframes between two adjustments of everything.
        full_limit: keyframes up to which everything is adjusted.
    """

    keyframe_distance: float = 0.06
    keyframe_gap_frames: int = 3
    least_parallax_deg: float = 0.8
    worst_error_px: float = 1.5
    window: int = 14
    keyframes_kept: int = 120
    full_every: int = 6
    full_limit: int = 60


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveConfig:
    """The live tracker.

    Attributes:
        in_process: whether mapping runs in the caller's process, for tests.
        lag_frames: the map that a keyframe leads to is taken over so many frames later. None takes
            it over as soon as it is there, which is what a camera wants; a number waits for it,
            so that a recording gives the same poses each time.
        new_map_after_s: a track that is lost for longer starts another map, which is merged when
            it meets the one before.
    """

    front_end: FrontEndConfig = field(default_factory=FrontEndConfig)
    bootstrap: BootstrapConfig = field(default_factory=BootstrapConfig)
    mapping: MappingConfig = field(default_factory=MappingConfig)
    in_process: bool = False
    lag_frames: int | None = None
    new_map_after_s: float = 2.0
