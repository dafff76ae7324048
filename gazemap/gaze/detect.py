"""Fixations of a head-worn eye tracker: where gaze rests in the world while the head moves.

A head that moves drags gaze along in the image although the eye holds a point. Each sample is
therefore carried to the support plane (or a usual distance) by the camera's pose, and steps are
measured between such points as the camera sees them at one moment: what is left is the eye's own
motion. Without a pose the motion of the image, from optic flow, has to do.

Source:
    Velocity threshold (I-VT) and dispersion threshold (I-DT): Salvucci and Goldberg 2000; the
    threshold follows the noise as in Nystrom and Holmqvist 2010.
"""

import numpy as np

from gazemap.gaze.config import FixationConfig, FixationMethod
from gazemap.gaze.directions import directions_of
from gazemap.gaze.flow import ImageMotion
from gazemap.gaze.refixations import noise_in_rests_deg, split_refixations
from gazemap.gaze.steady import SteadyGaze
from gazemap.geometry.arrays import BoolArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.types.session import Blink, Fixation, GazeSamples
from gazemap.types.tracking import Trajectory

_MAX_SAMPLE_GAP_S = 0.075


def detect_fixations(
    gaze: GazeSamples,
    camera: Camera,
    trajectory: Trajectory | None,
    blinks: tuple[Blink, ...],
    config: FixationConfig,
    *,
    motion: ImageMotion | None = None,
) -> tuple[Fixation, ...]:
    """Return the fixations in time order, numbered from 1.

    Args:
        gaze: samples; those in blinks, not worn or without a pixel are left out.
        camera: the scene camera.
        trajectory: its path, or None where there is none.
        blinks: intervals without gaze, beside those marked in the samples.
        config: settings.
        motion: how its image moved where it has no pose, if that is known.
    """
    keep = _usable(gaze, blinks)
    t_ns, uv_px = gaze.t_ns[keep], gaze.uv_px[keep]
    if len(t_ns) < 5:
        return ()
    steady = SteadyGaze(t_ns, camera.unproject(uv_px), trajectory, config, motion)
    find = _by_velocity if config.method is FixationMethod.VELOCITY else _by_dispersion
    spans = [s for s in find(steady, config) if len(s) >= 3]
    spans = _merged(spans, steady, config)
    if config.method is FixationMethod.VELOCITY:
        sigma_deg = noise_in_rests_deg(spans, steady)
        spans = [p for s in spans for p in split_refixations(s, steady, sigma_deg, config)]
    found = [s for s in spans if (t_ns[s[-1]] - t_ns[s[0]]) * 1e-9 >= config.min_duration_s]
    return tuple(_fixation(n + 1, s, steady, camera) for n, s in enumerate(found))


def _fixation(fixation_id: int, span: IntArray, steady: SteadyGaze, camera: Camera) -> Fixation:
    """Return a fixation; its pixel is where the held point lay at mid-time."""
    middle = np.full(len(span), span[len(span) // 2])
    seen_deg = np.median(steady.seen_from(middle, span), axis=0)
    u_px, v_px = camera.project(directions_of(np.radians(seen_deg[None])))[0]
    return Fixation(
        fixation_id=fixation_id,
        start_ns=int(steady.t_ns[span[0]]),
        end_ns=int(steady.t_ns[span[-1]]),
        u_px=float(u_px),
        v_px=float(v_px),
    )


def _usable(gaze: GazeSamples, blinks: tuple[Blink, ...]) -> BoolArray:
    keep = gaze.worn & ~gaze.blink & np.isfinite(gaze.uv_px).all(axis=1)
    for blink in blinks:
        keep &= (gaze.t_ns < blink.start_ns) | (gaze.t_ns > blink.end_ns)
    return np.asarray(keep)


def _by_velocity(steady: SteadyGaze, config: FixationConfig) -> list[IntArray]:
    """Split where the median direction steps; the step must stand out of the noise."""
    width = max(2, round(config.window_s / steady.period_s))
    count = len(steady.t_ns)
    centre = np.arange(count)[:, None]
    offsets = np.arange(-width, width)
    at = np.clip(centre + offsets, 0, count - 1)
    seen = steady.seen_from(np.broadcast_to(centre, at.shape), at)  # (N, 2 * width, 2)
    before, after = np.median(seen[:, :width], axis=1), np.median(seen[:, width:], axis=1)
    step = np.linalg.norm(after - before, axis=1)
    # A sample's neighbour differs by noise alone but for the few samples in saccades.
    noise = 1.4826 * np.median(np.abs(np.diff(seen[:, width - 1 : width + 1], axis=1))) / np.sqrt(2)
    limit = max(config.min_jump_deg, config.noise_factor * noise * np.sqrt(2.0 / width) * 1.25)
    is_still = step < limit
    spans = _runs(is_still, steady.t_ns)
    return [_grown(s, steady, noise, width) for s in spans if len(s) >= 3]


def _runs(flags: BoolArray, t_ns: IntArray) -> list[IntArray]:
    """Return index runs where flags hold, split at gaps in time."""
    index = np.flatnonzero(flags)
    if len(index) == 0:
        return []
    gap_ns = np.diff(t_ns[index])
    cuts = np.flatnonzero((np.diff(index) > 1) | (gap_ns > _MAX_SAMPLE_GAP_S * 1e9)) + 1
    return np.split(index, cuts)


def _grown(span: IntArray, steady: SteadyGaze, noise_deg: float, width: int) -> IntArray:
    """Return the span with the samples at its ends that belong to it.

    The step is already high half a window before a saccade begins.
    """
    centre = np.median(steady.seen_from(np.full(len(span), span[0]), span), axis=0)
    limit = max(4.0 * noise_deg, 0.3)

    def belongs(k: int, beside: int) -> bool:
        is_next = abs(int(steady.t_ns[k] - steady.t_ns[beside])) <= _MAX_SAMPLE_GAP_S * 1e9
        seen = steady.seen_from(span[:1], np.array([k]))[0]
        return is_next and bool(np.linalg.norm(seen - centre) < limit)

    low, high = int(span[0]), int(span[-1])
    low_end, high_end = max(low - width, 0), min(high + width, len(steady.t_ns) - 1)
    while low > low_end and belongs(low - 1, low):
        low -= 1
    while high < high_end and belongs(high + 1, high):
        high += 1
    return np.arange(low, high + 1)


def _by_dispersion(steady: SteadyGaze, config: FixationConfig) -> list[IntArray]:
    """Grow each span while its directions stay within the allowed spread."""
    spans: list[IntArray] = []
    start, count = 0, len(steady.t_ns)
    min_ns = int(config.min_duration_s * 1e9)
    while start < count:
        end = int(np.searchsorted(steady.t_ns, steady.t_ns[start] + min_ns))
        if end >= count:
            break
        if _spread(steady, start, end) > config.dispersion_deg:
            start += 1
            continue
        while end + 1 < count and _spread(steady, start, end + 1) <= config.dispersion_deg:
            end += 1
        spans.append(np.arange(start, end + 1))
        start = end + 1
    return spans


def _spread(steady: SteadyGaze, start: int, end: int) -> float:
    """Return how far directions spread: 5th to 95th percentile, the larger of the two axes."""
    index = np.arange(start, end + 1)
    seen = steady.seen_from(np.full(len(index), start), index)
    low, high = np.percentile(seen, [5, 95], axis=0)
    return float((high - low).max())


def _merged(spans: list[IntArray], steady: SteadyGaze, config: FixationConfig) -> list[IntArray]:
    merged: list[IntArray] = []
    for span in spans:
        if merged and _is_one(merged[-1], span, steady, config):
            merged[-1] = np.arange(merged[-1][0], span[-1] + 1)
        else:
            merged.append(span)
    return merged


def _is_one(a: IntArray, b: IntArray, steady: SteadyGaze, config: FixationConfig) -> bool:
    """Return whether gaze rests where it did; a blink does not end a look."""
    if b[0] <= a[-1]:
        return True
    gap_s = (steady.t_ns[b[0]] - steady.t_ns[a[-1]]) * 1e-9
    limit_deg = config.merge_deg
    if gap_s > config.merge_gap_s:
        if b[0] - a[-1] > 1 or gap_s > config.blink_gap_s:
            return False
        around = max(3, round(config.min_duration_s / steady.period_s))
        a, b, limit_deg = a[-around:], b[:around], config.blink_deg
    both = [np.median(steady.seen_from(np.full(len(s), b[0]), s), axis=0) for s in (a, b)]
    return bool(np.linalg.norm(both[1] - both[0]) < limit_deg)
