"""Settings of the gaze stage."""

from dataclasses import dataclass
from enum import StrEnum


class FixationMethod(StrEnum):
    """How fixations are told from saccades."""

    VELOCITY = "velocity"
    DISPERSION = "dispersion"


@dataclass(frozen=True, slots=True, kw_only=True)
class FixationConfig:
    """When gaze rests.

    Attributes:
        method: by the speed of gaze in world, or by how far it spreads.
        window_s: speed is the difference of the medians over such windows before and after.
        min_jump_deg: a smaller step is no saccade.
        noise_factor: how many times the noise of the step a saccade must be.
        dispersion_deg: how far gaze may spread within a fixation (method dispersion).
        split_penalty: by how much (in half chi-squares) two drifting rests must explain a span
            better than one: small saccades drown in the noise of single samples.
        usual_duration_s: the usual length of a rest ...
        duration_log_sigma: ... and the standard deviation of its logarithm.
        drift_sigma_deg: how far a rest's mean drifts where the head's pose is not known.
        merge_gap_s: fixations closer in time than this are one ...
        merge_deg: ... if they are closer in direction than this as well.
        blink_gap_s: so long without any sample is bridged (a blink) ...
        blink_deg: ... if gaze is no farther than this from where it was.
        min_duration_s: anything shorter is no fixation.
        assumed_distance_m: how far gaze is taken to reach where it meets no table.
    """

    method: FixationMethod = FixationMethod.VELOCITY
    window_s: float = 0.03
    min_jump_deg: float = 0.6
    noise_factor: float = 4.0
    dispersion_deg: float = 1.5
    split_penalty: float = 6.0
    usual_duration_s: float = 0.3
    duration_log_sigma: float = 0.45
    drift_sigma_deg: float = 0.04
    merge_gap_s: float = 0.075
    merge_deg: float = 0.25
    blink_gap_s: float = 0.25
    blink_deg: float = 1.0
    min_duration_s: float = 0.1
    assumed_distance_m: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class OffsetConfig:
    """How a session's constant gaze error is found.

    Attributes:
        max_deg: larger errors are not looked for.
        start_sigma_deg: how far from an object's centre people look, at first.
        usual_spread_deg: the same as people's looks mostly have it ...
        usual_spread_looks: ... which counts as much as so many looks of the session.
        min_sigma_deg: nobody looks more exactly.
        on_object: share of fixations that are on objects, at first.
        usual_deg: standard deviation of eye trackers' errors.
        reach_s: a thing is looked at for so long before it is taken.
        in_use: how much more a thing in use is looked at than one that just stands there.
        place_sigma_deg: how far off a place is thought to be, the same for all looks at it.
        ahead_s: a thing's next place is looked at so long before it gets there.
        systematic_deg: how far the error is from constant over the image, and people's aim from
            the middle of things, whatever the number of fixations.
        significance: the error is taken out if its squared Mahalanobis length is above this
            (chi-square of two degrees at 95 %).
        unknown_sigma_deg: how well gaze is known where nothing could be estimated.
    """

    max_deg: float = 5.0
    start_sigma_deg: float = 0.7
    usual_spread_deg: float = 0.35
    usual_spread_looks: float = 10.0
    min_sigma_deg: float = 0.1
    on_object: float = 0.5
    usual_deg: float = 2.0
    reach_s: float = 3.0
    in_use: float = 8.0
    place_sigma_deg: float = 0.25
    ahead_s: float = 6.0
    systematic_deg: float = 0.08
    significance: float = 5.99
    unknown_sigma_deg: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class GazeNoise:
    """What is uncertain about one fixation's ray.

    Attributes:
        fixation_sigma_deg: of a fixation's direction, apart from the constant offset.
        pose_sigma_m: of the camera's place.
        pose_sigma_deg: of the camera's heading.
        change_sigma_s: of the moments at which things are put down and taken up.
    """

    fixation_sigma_deg: float = 0.06
    pose_sigma_m: float = 0.0005
    pose_sigma_deg: float = 0.02
    change_sigma_s: float = 0.25
