"""What GLIDE assumes before it has seen a session; from there on it learns."""

from dataclasses import dataclass
from enum import StrEnum


class Inference(StrEnum):
    """How the posterior is computed."""

    EXACT = "exact"
    DIRICHLET = "dirichlet"


@dataclass(frozen=True, slots=True, kw_only=True)
class GlideConfig:
    """Constants of the model in docs/glide.md.

    Attributes:
        aim_sigma_m: spread of where on a thing people look, beside the covariance.
        outlier_weight: share of looks within an action that go elsewhere.
        in_hand_weight: share of a placing's early looks that go to the target's old place.
        landmark_weight: share of a placing's looks that go to the landmark.
        unseen_prior: prior of a target that vision has no instance of, where it has some.
        skip_prior: prior of an instruction that was said and not done.
        action_s: median duration of one action.
        action_log_sigma: spread of its logarithm.
        action_max_s: no action lasts longer.
        gap_fixations: expected background fixations between two actions on different things.
        gap_in_hand_fixations: the same between taking a thing and putting it.
        narration_sigma_s: prior spread of the start of speech against the start of the action.
        narration_outlier: share of times in the transcript that say nothing.
        motion_sigma_s: spread of a gaze leaving its landmark against the event that vision saw.
        motion_window_s: no gaze leaves its landmark farther from the event than this.
        motion_missed: prior of a movement that vision missed.
        unmoved_prior: prior of a taken thing of which vision saw no movement.
        exchanged_prior: prior of two neighbouring things that were done the other way round.
        relation_missed: prior of a thing that was put elsewhere than the words say.
        popular_share: prior share of idle looks that rest on things, not just anywhere.
        gaze_offset_sigma_rad: prior spread of the gaze offset that mapping left in, per axis.
        grid_spacing_m: spacing of the grid of positions where there is no instance.
        rest_height_m: height above the table of the middle of a thing that was not seen.
        rounds: passes of learning the session's parameters.
        inference: exact, or by sampling as in the paper.
        samples: partitions drawn by the Dirichlet inference.
        dirichlet_strength: its parameters are the expected seconds of the segments times this.
        window: most instructions that are aligned at once.
        live_window: the same while the session goes on.
        scene_unit_m: one metre in the units of the world frame; not 1 where the scale is arbitrary.
    """

    aim_sigma_m: float = 0.006
    outlier_weight: float = 0.2
    in_hand_weight: float = 0.15
    landmark_weight: float = 0.2
    unseen_prior: float = 0.03
    skip_prior: float = 0.05
    action_s: float = 2.0
    action_log_sigma: float = 0.6
    action_max_s: float = 15.0
    gap_fixations: float = 2.0
    gap_in_hand_fixations: float = 0.5
    narration_sigma_s: float = 2.0
    narration_outlier: float = 0.05
    motion_sigma_s: float = 0.5
    motion_window_s: float = 10.0
    motion_missed: float = 0.05
    exchanged_prior: float = 0.01
    relation_missed: float = 0.2
    popular_share: float = 0.1
    unmoved_prior: float = 0.02
    gaze_offset_sigma_rad: float = 0.015
    grid_spacing_m: float = 0.012
    rest_height_m: float = 0.018
    rounds: int = 6
    inference: Inference = Inference.EXACT
    samples: int = 10_000
    dirichlet_strength: float = 4.0
    window: int = 40
    live_window: int = 12
    scene_unit_m: float = 1.0
