"""Settings of the scene: objects, surface and the rays cast into them."""

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True, kw_only=True)
class ForegroundConfig:
    """What stands out of the table in a view from above.

    Attributes:
        reduction: images are reduced by this factor before they are segmented.
        min_distance_sigma: how far a colour must lie from the table's.
        min_area_m2: smaller regions, measured on the table, are dropped.
        max_length_m: longer regions are dropped: no object, or an arm.
    """

    reduction: int = 2
    min_distance_sigma: float = 4.5
    min_area_m2: float = 1.0e-4
    max_length_m: float = 0.25


@dataclass(frozen=True, slots=True, kw_only=True)
class SiteConfig:
    """When something is at rest.

    Attributes:
        settle_s: a region counts as resting after it stood still for so long.
        max_shift_m: regions closer than this are the same one.
        min_same: share of a site's pixels that must look as before for it to be recognised.
        max_bare: share of its pixels that may look like the table while it is there.
        min_bare: share of its pixels that look like the table once it has left.
        empty_s: the table must show, unchanged, for so long before a place counts as empty.
        max_change: what counts as unchanged from frame to frame, in 8-bit CIELAB.
        history_s: how far back a thing's arrival is looked for.
    """

    settle_s: float = 0.4
    max_shift_m: float = 0.004
    min_same: float = 0.25
    max_bare: float = 0.2
    min_bare: float = 0.6
    empty_s: float = 0.5
    max_change: float = 6.0
    history_s: float = 4.0


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxFitConfig:
    """How a box is fitted to its silhouettes.

    Attributes:
        crop_px: side of the square cut-outs that are compared.
        start_heights_m: heights from which the search starts.
        min_height_m: anything lower is a mark on the table.
        min_side_m: anything narrower is no object.
        max_side_m: anything longer is no object.
        max_plan_m: nor is anything that is longer on the table.
        max_slenderness: anything higher than so many times its thinner side would topple: it is
            held, an arm for example.
        min_clarity: mean log-odds of a thing's colours against its surroundings, in each view.
        min_gain: by how much a box must explain each of its pixels better than a flat mark does
            (log-likelihood).
        min_views: views beside the one from above that a height needs.
        max_views: views that are kept for one resting place.
        view_period_s: views of one resting place are at least so far apart.
        sigma_floor_m: no centre is claimed to be known better.
        edge_sigma_px: how far off an outline's edge is, the same in all views: pixels there mix
            the colours of both sides, and shadows lie beside it.
    """

    crop_px: int = 96
    start_heights_m: tuple[float, ...] = (0.004, 0.018, 0.035, 0.06)
    min_height_m: float = 0.007
    min_side_m: float = 0.008
    max_side_m: float = 0.30
    max_plan_m: float = 0.30
    max_slenderness: float = 8.0
    min_clarity: float = 1.2
    min_gain: float = 0.09
    min_views: int = 3
    max_views: int = 10
    view_period_s: float = 0.35
    sigma_floor_m: float = 0.001
    edge_sigma_px: float = 0.75


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepConfig:
    """How surroundings are measured from several views of one camera.

    Attributes:
        views: so many views get a depth image.
        pool: so many views are there to be compared with.
        partners: views that each of them is compared with.
        width_px: width of the images that are compared.
        planes: depths that are tried.
        patch_px: side of the patches that are compared.
        grey_sigma: what a patch varies by is noise (8-bit grey levels).
        min_alikeness: correlation below which nothing was measured.
        step_cost: for a neighbour one plane off, in units of 1 - correlation.
        jump_cost: for a neighbour farther off.
        tolerance: depths of two views agree if they differ by less than this share.
        min_agreeing: other views that must agree.
        min_fitted_share: smaller parts of an image get no plane ...
        max_fitted_share: ... nor do larger ones.
        plane_tolerance: how far a plane's support may lie off it, as a share of its distance.
        voxel_share: the fused surface is as fine as this share of the usual distance.
    """

    views: int = 16
    pool: int = 40
    partners: int = 3
    width_px: int = 256
    planes: int = 64
    patch_px: int = 7
    grey_sigma: float = 2.5
    min_alikeness: float = 0.5
    step_cost: float = 0.06
    jump_cost: float = 0.5
    tolerance: float = 0.02
    min_agreeing: int = 2
    min_fitted_share: float = 0.002
    max_fitted_share: float = 0.5
    plane_tolerance: float = 0.012
    voxel_share: float = 0.012


@dataclass(frozen=True, slots=True, kw_only=True)
class SceneConfig:
    """Settings of the scene stage.

    Attributes:
        head_period_s: head frames are looked at this far apart.
        rectified_period_s: the same where there is no overhead camera and they stand in for it.
        margin_m: the table goes on for so long beyond its outermost tags.
        depth_period_s: depth images are fused this far apart.
        voxel_m: the fused surface is as fine as this.
        surface_sigma_m: standard deviation of the table along its normal.
        measured_sigma_share: standard deviation of the surroundings, as a share of the usual
            distance.
    """

    foreground: ForegroundConfig = field(default_factory=ForegroundConfig)
    sites: SiteConfig = field(default_factory=SiteConfig)
    fit: BoxFitConfig = field(default_factory=BoxFitConfig)
    sweep: SweepConfig = field(default_factory=SweepConfig)
    head_period_s: float = 0.15
    rectified_period_s: float = 0.1
    margin_m: float = 0.10
    depth_period_s: float = 0.5
    voxel_m: float = 0.008
    surface_sigma_m: float = 0.0005
    measured_sigma_share: float = 0.01
