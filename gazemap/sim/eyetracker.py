"""What the glasses record of the eyes: gaze samples, fixations and blinks, with their errors."""

from dataclasses import dataclass

import numpy as np

from gazemap.geometry.arrays import FloatArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.sim.config import SimConfig
from gazemap.sim.eyes import Look
from gazemap.sim.head import HeadPath

_FIRST_SAMPLE_S = 0.0011
_BLINK_S = (0.09, 0.22)
_FIXATION_SIGMA_PX = 0.17


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EyeRecord:
    """The eye tracker's streams; times are seconds from the first frame.

    Attributes:
        t_s: (N,) of the gaze samples.
        uv_px: (N, 2) on the distorted image.
        fixation: (N,) number of the fixation from 1 on, 0 in a saccade.
        blink: (N,) number of the blink from 1 on, 0 with open eyes.
        azimuth_elevation_deg: (N, 2) of the recorded pixel; right and up are positive.
        looks_px: (L, 2) pixel of each fixation.
        looks_deg: (L, 2) its azimuth and elevation.
        blinks_s: (B, 2) start and end.
        offset_px: (2,) the constant error that is in all pixels.
    """

    t_s: FloatArray
    uv_px: FloatArray
    fixation: IntArray
    blink: IntArray
    azimuth_elevation_deg: FloatArray
    looks_px: FloatArray
    looks_deg: FloatArray
    blinks_s: FloatArray
    offset_px: FloatArray


def record_eyes(
    looks: tuple[Look, ...],
    head: HeadPath,
    camera: Camera,
    config: SimConfig,
    rng: np.random.Generator,
) -> EyeRecord:
    """Return what the eye tracker gives for the fixations."""
    offset_px = _offset_px(camera, config.person.gaze_offset_deg, rng)
    t_s = np.arange(_FIRST_SAMPLE_S, config.seconds, 1.0 / config.gaze_rate_hz)
    points, fixation = _gazed_points(looks, t_s)
    noise_px = np.radians(config.person.gaze_noise_deg) * camera.K[0, 0]
    uv_px = _seen_px(points, t_s, head=head, camera=camera) + offset_px
    uv_px += rng.normal(0.0, noise_px, uv_px.shape)
    middle_s = np.array([(look.start_s + look.end_s) / 2 for look in looks])
    at = np.array([look.point_world for look in looks])
    looks_px = _seen_px(at, middle_s, head=head, camera=camera) + offset_px
    looks_px += rng.normal(0.0, _FIXATION_SIGMA_PX, looks_px.shape)
    blinks_s = _draw_blinks(config, rng)
    return EyeRecord(
        t_s=t_s,
        uv_px=uv_px,
        fixation=fixation,
        blink=_numbered(blinks_s, t_s),
        azimuth_elevation_deg=_angles_deg(uv_px, camera),
        looks_px=looks_px,
        looks_deg=_angles_deg(looks_px, camera),
        blinks_s=blinks_s,
        offset_px=offset_px,
    )


def _offset_px(camera: Camera, offset_deg: float, rng: np.random.Generator) -> FloatArray:
    angle = rng.uniform(0.0, 2.0 * np.pi)
    size_px = np.radians(offset_deg) * camera.K[0, 0]
    return np.asarray(size_px * np.array([np.cos(angle), np.sin(angle)]))


def _gazed_points(looks: tuple[Look, ...], t_s: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return what is looked at (N, 3) and the fixation's number; saccades swing smoothly over."""
    points = np.array([look.point_world for look in looks])
    starts, ends = np.array([(look.start_s, look.end_s) for look in looks]).T
    i = np.clip(np.searchsorted(starts, t_s, side="right") - 1, 0, None)
    following = np.minimum(i + 1, len(looks) - 1)
    span_s = np.maximum(starts[following] - ends[i], 1e-3)
    a = np.clip((t_s - ends[i]) / span_s, 0.0, 1.0)[:, None]
    s = a**3 * (10.0 - 15.0 * a + 6.0 * a * a)
    inside = (t_s >= starts[i]) & (t_s <= ends[i])
    return points[i] * (1.0 - s) + points[following] * s, np.where(inside, i + 1, 0)


def _seen_px(
    points_world: FloatArray, t_s: FloatArray, *, head: HeadPath, camera: Camera
) -> FloatArray:
    R, p = head.poses(t_s)
    points_cam = np.einsum("nji,nj->ni", R, points_world - p)
    uv_px: FloatArray = camera.project(np.asarray(points_cam))
    return uv_px


def _angles_deg(uv_px: FloatArray, camera: Camera) -> FloatArray:
    ray = camera.unproject(uv_px)
    azimuth, elevation = np.arctan2(ray[:, 0], ray[:, 2]), -np.arcsin(ray[:, 1])
    return np.asarray(np.degrees(np.column_stack([azimuth, elevation])))


def _draw_blinks(config: SimConfig, rng: np.random.Generator) -> FloatArray:
    count = int(rng.poisson(config.person.blinks_per_s * config.seconds))
    starts = np.sort(rng.uniform(0.5, config.seconds - 0.5, count))
    apart = np.diff(starts, prepend=-1.0) > 2 * _BLINK_S[1]
    kept: FloatArray = starts[apart]
    return np.column_stack([kept, kept + rng.uniform(*_BLINK_S, len(kept))])


def _numbered(intervals_s: FloatArray, t_s: FloatArray) -> IntArray:
    number = np.zeros(len(t_s), dtype=np.int64)
    for k, (start, end) in enumerate(intervals_s):
        number[(t_s >= start) & (t_s <= end)] = k + 1
    return number
