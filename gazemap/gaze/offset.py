"""A session's constant gaze error, found from how fixations gather on objects.

Eye trackers err by a constant angle for a wearer. People mostly look at things and at the places
where they will put them; so the error is the shift that brings most fixations onto such points.

Model: a fixation's angles are those of one of the points that might be looked at, plus the
offset, plus a spread; or they are anywhere. Offset, spread and share are found by
expectation-maximisation from the best of a grid of starts.
"""

from dataclasses import dataclass

import numpy as np

from gazemap.gaze.config import OffsetConfig
from gazemap.gaze.directions import angles_of
from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.camera import Camera
from gazemap.types.fixation import GazeOffset
from gazemap.types.scene import SceneObject
from gazemap.types.session import Fixation
from gazemap.types.tracking import Trajectory

_ANYWHERE_DEG2 = 60.0 * 40.0  # where gaze goes in a scene camera
_MIN_FIXATIONS = 8
_ROUNDS = 60


def estimate_gaze_offset(
    fixations: tuple[Fixation, ...],
    *,
    trajectory: Trajectory,
    camera: Camera,
    objects: tuple[SceneObject, ...],
    config: OffsetConfig,
) -> GazeOffset:
    """Return the offset with its uncertainty; it is applied where it is significant."""
    pulls = _differences(fixations, trajectory, camera, objects, config)
    if len(pulls) < _MIN_FIXATIONS:
        return _unknown(config)
    offset_deg, cov_deg2 = _expectation_maximisation(pulls, config)
    length = float(offset_deg @ np.linalg.solve(cov_deg2, offset_deg))
    sigma_rad = np.radians(np.sqrt(np.diag(cov_deg2)))
    offset_rad = np.radians(offset_deg)
    return GazeOffset(
        azimuth_rad=float(offset_rad[0]),
        elevation_rad=float(offset_rad[1]),
        azimuth_sigma_rad=float(sigma_rad[0]),
        elevation_sigma_rad=float(sigma_rad[1]),
        is_applied=length > config.significance,
    )


def _unknown(config: OffsetConfig) -> GazeOffset:
    sigma = float(np.radians(config.unknown_sigma_deg))
    return GazeOffset(
        azimuth_rad=0.0,
        elevation_rad=0.0,
        azimuth_sigma_rad=sigma,
        elevation_sigma_rad=sigma,
        is_applied=False,
    )


def _differences(
    fixations: tuple[Fixation, ...],
    trajectory: Trajectory,
    camera: Camera,
    objects: tuple[SceneObject, ...],
    config: OffsetConfig,
) -> list[FloatArray]:
    """Return for each fixation how far it lies from all points it might be on (K, 2), degrees."""
    pulls = []
    for fixation in fixations:
        t_ns = fixation.mid_ns
        T_world_cam = trajectory.at(t_ns)
        points = _points_of_interest(objects, t_ns, config)
        if T_world_cam is None or len(points) == 0:
            continue
        seen = angles_of(camera.unproject(np.array([[fixation.u_px, fixation.v_px]])))
        wanted = angles_of(T_world_cam.inverse().transform(points))
        pulls.append(np.degrees(seen - wanted))
    return pulls


def _points_of_interest(
    objects: tuple[SceneObject, ...], t_ns: int, config: OffsetConfig
) -> FloatArray:
    """Return the centres (K, 3) of what stands there, and of where things will soon be put."""
    points = []
    for thing in objects:
        state = thing.at(t_ns)
        if state is not None:
            points.append(state.T_world_body.t)
        coming = [s for s in thing.track if 0 < s.t_ns - t_ns < config.ahead_s * 1e9]
        points += [s.T_world_body.t for s in coming[:1]]
    return np.array(points).reshape(-1, 3)


@dataclass(slots=True, kw_only=True)
class _State:
    offset: FloatArray
    sigma: float
    share: float


def _expectation_maximisation(
    pulls: list[FloatArray], config: OffsetConfig
) -> tuple[FloatArray, FloatArray]:
    steps = np.arange(-config.max_deg, config.max_deg + 0.1, 0.25)
    start = _State(offset=np.zeros(2), sigma=config.start_sigma_deg, share=config.on_object)
    grid = [np.array([a, e]) for a in steps for e in steps]
    heights = [_log_likelihood(pulls, offset, start) for offset in grid]
    state = start
    state.offset = grid[int(np.argmax(heights))]
    for _ in range(_ROUNDS):
        state = _update(pulls, state, config)
    return state.offset, _covariance(pulls, state) + config.systematic_deg**2 * np.eye(2)


def _memberships(pulls: FloatArray, offset: FloatArray, state: _State) -> FloatArray:
    """Return the joint densities (K + 1,) of lying on each point, and of lying anywhere."""
    square = ((pulls - offset) ** 2).sum(axis=1) / state.sigma**2
    on_point = state.share / len(pulls) * np.exp(-0.5 * square) / (2 * np.pi * state.sigma**2)
    return np.append(on_point, (1 - state.share) / _ANYWHERE_DEG2)


def _log_likelihood(pulls: list[FloatArray], offset: FloatArray, state: _State) -> float:
    return float(sum(np.log(_memberships(p, offset, state).sum()) for p in pulls))


def _update(pulls: list[FloatArray], state: _State, config: OffsetConfig) -> _State:
    weights = [_memberships(p, state.offset, state) for p in pulls]
    weights = [(w / w.sum())[:-1] for w in weights]
    flat, weight = np.concatenate(pulls), np.concatenate(weights)
    total = max(float(weight.sum()), 1e-9)
    offset = weight @ flat / total
    variance = weight @ ((flat - offset) ** 2).sum(axis=1) / (2 * total)
    return _State(
        offset=offset,
        sigma=max(float(np.sqrt(variance)), config.min_sigma_deg),
        share=float(np.clip(total / len(pulls), 0.05, 0.95)),
    )


def _covariance(pulls: list[FloatArray], state: _State) -> FloatArray:
    """Return the inverse of the observed information (2, 2), degrees^2."""
    step = 0.25 * state.sigma
    axes = np.eye(2) * step

    def value(offset: FloatArray) -> float:
        return _log_likelihood(pulls, state.offset + offset, state)

    information = np.empty((2, 2))
    for i in range(2):
        for j in range(2):
            a, b = axes[i], axes[j]
            mixed = value(a + b) - value(a - b) - value(b - a) + value(-a - b)
            information[i, j] = -mixed / (4 * step**2)
    values, vectors = np.linalg.eigh(information)
    cov: FloatArray = (vectors / np.maximum(values, 1.0)) @ vectors.T
    return cov
