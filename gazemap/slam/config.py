"""What can be set in tracking and mapping."""

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True, kw_only=True)
class KltConfig:
    """Following corners from frame to frame.

    Attributes:
        cell_count: the image is divided into about so many cells, one corner wanted in each.
        window_px: side of the window that is followed.
        levels: pyramid levels above the full image.
        forward_backward_px: a corner that does not come back this close is dropped.
        top_up_every: empty cells are filled each so many frames.
        corner_quality: smallest minimal eigenvalue of the gradients' covariance, grey^2 per px^2.
        blank_grey: a frame whose brightness spreads less than this is blank.
    """

    cell_count: int = 350
    window_px: int = 15
    levels: int = 3
    forward_backward_px: float = 0.3
    top_up_every: int = 4
    corner_quality: float = 1.5
    blank_grey: float = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class PatchConfig:
    """Re-alignment of map points to their reference patches.

    Attributes:
        candidates_in_view: about so many points are looked for in each keyframe.
        points_in_view: about so many points are wanted in view of each keyframe.
        half_px: the patch reaches so far from its centre.
        iterations: at most so many Gauss-Newton steps.
        zncc: smallest correlation that counts as found.
        search_px: a patch that ends farther from its prediction is not believed.
    """

    candidates_in_view: int = 1000
    points_in_view: int = 400
    half_px: int = 6
    iterations: int = 12
    zncc: float = 0.85
    search_px: float = 6.0


@dataclass(frozen=True, slots=True, kw_only=True)
class SlamConfig:
    """Tracking and mapping.

    Attributes:
        keyframe_shift_px: a keyframe is due when corners moved so far in the median.
        keyframe_survivors: or when fewer than this part of the last keyframe's corners are left.
        keyframe_gap: or after so many frames.
        keyframe_rest: but not within so many frames, unless hardly any corner is left.
        bundle_cauchy_px: scale of the robust loss while the map grows.
        final_cauchy_px: scale of the robust loss on aligned patches.
        min_inliers: a pose from fewer points is none.
        min_parallax_deg: a point is triangulated from rays at least this far apart.
        tag_family: of tags that no layout names.
        tag_size_m: the side of their black square, which gives the scale where nothing else does.
        memory_bytes: grey frames beyond this are decoded again instead of being kept.
    """

    klt: KltConfig = field(default_factory=KltConfig)
    patch: PatchConfig = field(default_factory=PatchConfig)
    keyframe_shift_px: float = 30.0
    keyframe_survivors: float = 0.6
    keyframe_gap: int = 12
    keyframe_rest: int = 5
    bundle_cauchy_px: float = 0.5
    final_cauchy_px: float = 0.25
    min_inliers: int = 15
    min_parallax_deg: float = 1.5
    tag_family: str = "tag36h11"
    tag_size_m: float | None = None
    memory_bytes: int = 500_000_000
