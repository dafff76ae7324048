"""A session's constant gaze error, found from how fixations gather on objects.

Eye trackers err by a constant angle for a wearer. People mostly look at things and at the places
where they will put them; so the error is the shift that brings most fixations onto such points.

Model: a fixation's angles are those of one of the points that might be looked at, plus the
offset, plus a spread; or they are anywhere. What is taken up next and where it will be put is
looked at far more than the rest. Offset, spread and share are found by expectation-maximisation
from the best of a grid of starts. Another offset may explain the fixations nearly as well (things
stand a few degrees apart): what the grid leaves possible elsewhere is part of the uncertainty.

Source:
    Johansson et al. 2001 for where people look while they handle things.
"""

from dataclasses import dataclass

import numpy as np

from gazemap.gaze.config import OffsetConfig
from gazemap.gaze.directions import angles_of
from gazemap.geometry.arrays import FloatArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.types.fixation import GazeOffset
from gazemap.types.scene import SceneObject
from gazemap.types.session import Fixation
from gazemap.types.tracking import Trajectory

_ANYWHERE_DEG2 = 60.0 * 40.0  # where gaze goes in a scene camera
_MIN_FIXATIONS = 8
_ROUNDS = 60
_MOST_PLACES = 1000  # resting places of one thing
_GRID_STEP_DEG = 0.2
_PEAK_REACH = 4.0  # standard deviations; within them the peak's own covariance stands


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
    offset_deg, cov_deg2 = _posterior(pulls, config)
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Pulls:
    """How far one fixation lies from all points it might be on.

    Attributes:
        deg: (K, 2) azimuth and elevation.
        prior: (K,) how likely each point is to be looked at then; they sum to 1.
        point: (K,) which point it is, among all of the session.
    """

    deg: FloatArray
    prior: FloatArray
    point: IntArray


def _differences(
    fixations: tuple[Fixation, ...],
    trajectory: Trajectory,
    camera: Camera,
    objects: tuple[SceneObject, ...],
    config: OffsetConfig,
) -> list[_Pulls]:
    """Return for each fixation with a pose how far it lies from what might be looked at."""
    pulls = []
    for fixation in fixations:
        t_ns = fixation.mid_ns
        if _has_gone_astray(objects, t_ns, config):
            continue
        T_world_cam = trajectory.at(t_ns)
        points, weights, names = _points_of_interest(objects, t_ns, config)
        if T_world_cam is None or len(points) == 0:
            continue
        seen = angles_of(camera.unproject(np.array([[fixation.u_px, fixation.v_px]])))
        wanted = angles_of(T_world_cam.inverse().transform(points))
        prior = weights / weights.sum()
        pulls.append(_Pulls(deg=np.degrees(seen - wanted), prior=prior, point=names))
    return pulls


def _has_gone_astray(objects: tuple[SceneObject, ...], t_ns: int, config: OffsetConfig) -> bool:
    """Whether something was taken lately of which nobody knows where it was put.

    It is mostly looked where it goes: such looks lie near other things, and would draw the error
    towards those.
    """
    last = [thing.track[-1].left_ns for thing in objects]
    return any(left is not None and 0 <= t_ns - left < config.ahead_s * 1e9 for left in last)


def _points_of_interest(
    objects: tuple[SceneObject, ...], t_ns: int, config: OffsetConfig
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return the centres (K, 3) of what stands there and of where things will soon be put.

    Then their weights (K,): a thing that is about to be taken, or the place of one that is being
    carried, counts `in_use` times as much as a thing that just stands there. Then their names
    (K,): numbers that are the same for the same resting place.
    """
    points, weights, names = [], [], []
    for number, thing in enumerate(objects):
        state = thing.at(t_ns)
        if state is not None:
            soon = state.left_ns is not None and state.left_ns - t_ns < config.reach_s * 1e9
            points.append(state.T_world_body.t)
            weights.append(config.in_use if soon else 1.0)
            names.append(_MOST_PLACES * number + thing.track.index(state))
        coming = [s for s in thing.track if 0 < s.t_ns - t_ns < config.ahead_s * 1e9]
        for place in coming[:1]:
            points.append(place.T_world_body.t)
            weights.append(config.in_use if state is None else 1.0)
            names.append(_MOST_PLACES * number + thing.track.index(place))
    return np.array(points).reshape(-1, 3), np.array(weights), np.array(names, dtype=np.int64)


@dataclass(slots=True, kw_only=True)
class _State:
    offset: FloatArray
    sigma: float
    share: float


def _posterior(pulls: list[_Pulls], config: OffsetConfig) -> tuple[FloatArray, FloatArray]:
    """Return the most likely offset (2,) and its covariance (2, 2), degrees."""
    steps = np.arange(-config.max_deg, config.max_deg + 0.1, _GRID_STEP_DEG)
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    start = _State(offset=np.zeros(2), sigma=config.start_sigma_deg, share=config.on_object)
    usual = -0.5 * (grid**2).sum(axis=1) / config.usual_deg**2
    state = _fitted(pulls, grid[int(np.argmax(_heights(pulls, grid, start) + usual))], config)
    heights = _heights(pulls, grid, state) + usual
    better = grid[int(np.argmax(heights))]
    if np.linalg.norm(better - state.offset) > 2 * state.sigma:
        state = _fitted(pulls, better, config)
        heights = _heights(pulls, grid, state) + usual
    _, weight, worth = _weighted(pulls, state, config)
    independent = float(weight @ worth) / max(float(weight.sum()), 1e-9)
    cov = _covariance(pulls, state) / independent + config.systematic_deg**2 * np.eye(2)
    return state.offset, cov + _elsewhere(grid - state.offset, heights, cov)


def _fitted(pulls: list[_Pulls], offset: FloatArray, config: OffsetConfig) -> "_State":
    """Return the nearest best state from an offset on, by expectation-maximisation."""
    state = _State(offset=offset, sigma=config.start_sigma_deg, share=config.on_object)
    for _ in range(_ROUNDS):
        state = _update(pulls, state, config)
    return state


def _elsewhere(away: FloatArray, heights: FloatArray, cov: FloatArray) -> FloatArray:
    """Return the second moment (2, 2) of what the grid (N, 2) leaves possible out of the peak."""
    mass = np.exp(heights - heights.max())
    mass /= mass.sum()
    distance = np.einsum("ni,ij,nj->n", away, np.linalg.inv(cov), away)
    out = mass * (distance > _PEAK_REACH**2)
    moment: FloatArray = np.einsum("n,ni,nj->ij", out, away, away)
    return moment


def _heights(pulls: list[_Pulls], offsets: FloatArray, state: _State) -> FloatArray:
    """Return the log-likelihood of each offset (N, 2), with a state's spread and share."""
    total = np.zeros(len(offsets))
    for pull in pulls:
        square = ((pull.deg[:, None] - offsets) ** 2).sum(axis=-1) / state.sigma**2
        density = pull.prior @ np.exp(-0.5 * square) / (2 * np.pi * state.sigma**2)
        total += np.log(state.share * density + (1 - state.share) / _ANYWHERE_DEG2)
    return total


def _memberships(pull: _Pulls, state: _State) -> FloatArray:
    """Return the joint densities (K + 1,) of lying on each point, and of lying anywhere."""
    square = ((pull.deg - state.offset) ** 2).sum(axis=1) / state.sigma**2
    on_point = state.share * pull.prior * np.exp(-0.5 * square) / (2 * np.pi * state.sigma**2)
    return np.append(on_point, (1 - state.share) / _ANYWHERE_DEG2)


def _update(pulls: list[_Pulls], state: _State, config: OffsetConfig) -> _State:
    flat, weight, worth = _weighted(pulls, state, config)
    told = weight * worth
    offset = told @ flat / max(float(told.sum()), 1e-9)
    total = max(float(weight.sum()), 1e-9)
    usual = config.usual_spread_looks
    squares = weight @ ((flat - offset) ** 2).sum(axis=1) + 2 * usual * config.usual_spread_deg**2
    variance = squares / (2 * (total + usual))
    return _State(
        offset=offset,
        sigma=max(float(np.sqrt(variance)), config.min_sigma_deg),
        share=float(np.clip(total / len(pulls), 0.05, 0.95)),
    )


def _weighted(
    pulls: list[_Pulls], state: _State, config: OffsetConfig
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return all differences (N, 2), how surely each is meant (N,), and what it is worth (N,).

    Where a place is thought to be is wrong by `place_sigma_deg` for all looks at it alike, so ten
    looks at one place say less than one look at each of ten.
    """
    joint = [_memberships(p, state) for p in pulls]
    weight = np.concatenate([(w / w.sum())[:-1] for w in joint])
    place = np.concatenate([p.point for p in pulls])
    looks = np.bincount(place, weights=weight)[place]
    worth = state.sigma**2 / (state.sigma**2 + looks * config.place_sigma_deg**2)
    return np.concatenate([p.deg for p in pulls]), weight, worth


def _covariance(pulls: list[_Pulls], state: _State) -> FloatArray:
    """Return the inverse of the observed information (2, 2), degrees^2."""
    step = 0.25 * state.sigma
    a, b = np.eye(2) * step
    pairs = [(a, a), (a, b), (b, b)]
    around = [state.offset + s for x, y in pairs for s in (x + y, x - y, y - x, -x - y)]
    height = _heights(pulls, np.array(around), state).reshape(3, 4)
    aa, ab, bb = -(height @ [1.0, -1.0, -1.0, 1.0]) / (4 * step**2)
    values, vectors = np.linalg.eigh(np.array([[aa, ab], [ab, bb]]))
    cov: FloatArray = (vectors / np.maximum(values, 1.0)) @ vectors.T
    return cov
