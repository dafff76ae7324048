"""The start without a map: two views whose parallax fixes their geometry.

Hypotheses come from the essential matrix and from the homography; the one that puts most points
in front of both cameras with least error wins, unless another one explains them as well.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.live.config import BootstrapConfig, FrontEndConfig
from gazemap.slam.live.corners import find_corners
from gazemap.slam.live.flow import follow_both_ways
from gazemap.slam.live.refine import PoseProblem, refine_pose

_THRESHOLD_PX = 1.5
_LEAST_POINTS = 50
_MIDDLE_VIEWS = 4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BootView:
    """One frame of the start: the corners (N, 2) where it shows them, and its pose."""

    t_ns: int
    grey: ImageArray
    uv_px: FloatArray
    T_cam_world: Pose[Cam, World]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Start:
    """Posed frames, first to last; the first is the origin and the baseline has length 1."""

    views: tuple[BootView, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Geometry:
    T_cam_world: Pose[Cam, World]
    points_world: FloatArray
    good: BoolArray
    parallax_deg: float


@dataclass(slots=True, kw_only=True, eq=False)
class _Snapshot:
    t_ns: int
    grey: ImageArray
    uv_px: FloatArray


class Bootstrap:
    """Follows corners from a first frame until they have parallax."""

    def __init__(
        self,
        camera: Camera,
        *,
        config: BootstrapConfig,
        front_end: FrontEndConfig,
        rng: np.random.Generator,
    ) -> None:
        """Start without frames; `rng` samples the hypotheses."""
        self._rng = rng
        self._camera, self._config, self._front_end = camera, config, front_end
        self._snapshots: list[_Snapshot] = []
        self._alive: BoolArray = np.empty(0, bool)

    def push(self, grey: ImageArray, t_ns: int) -> Start | None:
        """Take a frame; return the start once there is one."""
        if not self._snapshots:
            self._restart(grey, t_ns)
            return None
        last = self._snapshots[-1]
        uv_px = np.full_like(last.uv_px, np.nan)
        moved, found = follow_both_ways(last.grey, grey, last.uv_px[self._alive], self._front_end)
        rows = np.flatnonzero(self._alive)
        uv_px[rows[found]] = moved[found]
        self._alive = np.isfinite(uv_px[:, 0])
        self._snapshots.append(_Snapshot(t_ns=t_ns, grey=grey, uv_px=uv_px))
        first_count = len(self._snapshots[0].uv_px)
        if self._alive.sum() < max(_LEAST_POINTS, 0.3 * first_count) or (
            len(self._snapshots) > self._config.longest_frames
        ):
            self._restart(grey, t_ns)
            return None
        return self._try_geometry()

    def reset(self) -> None:
        """Forget all frames."""
        self._snapshots = []

    def _restart(self, grey: ImageArray, t_ns: int) -> None:
        uv_px = find_corners(grey, np.empty((0, 2)), count=self._config.corners)
        self._snapshots = [_Snapshot(t_ns=t_ns, grey=grey, uv_px=uv_px)]
        self._alive = np.ones(len(uv_px), bool)

    def _try_geometry(self) -> Start | None:
        first, last = self._snapshots[0], self._snapshots[-1]
        rows = np.flatnonzero(self._alive)
        flow_px = np.linalg.norm(last.uv_px[rows] - first.uv_px[rows], axis=1)
        if np.median(flow_px) < self._config.least_flow_px:
            return None
        xy = self._camera.normalize(first.uv_px[rows]), self._camera.normalize(last.uv_px[rows])
        if _turn_residual(*xy) * float(self._camera.K[0, 0]) < self._needed_parallax_px():
            return None
        cv2.setRNGSeed(int(self._rng.integers(2**31)))
        geometry = _best_geometry(*xy, threshold=_THRESHOLD_PX / float(self._camera.K[0, 0]))
        if geometry is None or geometry.parallax_deg < self._config.least_parallax_deg:
            return None
        return self._posed(rows[geometry.good], geometry)

    def _needed_parallax_px(self) -> float:
        """Return what falls with time: a better start is worth some frames, not many."""
        config = self._config
        waited = min((len(self._snapshots) - 1) / config.patience_frames, 1.0)
        return (1 - waited) * config.wanted_parallax_px + waited * config.least_parallax_px

    def _posed(
        self, rows: np.ndarray[tuple[int], np.dtype[np.int64]], geometry: _Geometry
    ) -> Start:
        """Pose the frames between first and last by the points."""
        count = len(self._snapshots)
        chosen = np.unique(np.linspace(0, count - 1, min(count, _MIDDLE_VIEWS + 2)).astype(int))
        points = geometry.points_world[geometry.good]
        T: Pose[Cam, World] = Pose.identity()
        views = []
        for n in chosen:
            snapshot = self._snapshots[n]
            if n == count - 1:
                T = geometry.T_cam_world
            elif n > 0:
                T = self._pose(points, snapshot.uv_px[rows], T)
            views.append(
                BootView(t_ns=snapshot.t_ns, grey=snapshot.grey, uv_px=snapshot.uv_px[rows],
                         T_cam_world=T)
            )  # fmt: skip
        return Start(views=tuple(views))

    def _pose(
        self, points: FloatArray, uv_px: FloatArray, start: Pose[Cam, World]
    ) -> Pose[Cam, World]:
        problem = PoseProblem(
            points_world=points,
            xy=self._camera.normalize(uv_px),
            sigma=np.full(len(points), 1.0 / float(self._camera.K[0, 0])),
            dt_s=np.zeros(len(points)),
            twist=np.zeros(6),
        )
        fit = refine_pose(start, problem)
        return fit.T_cam_world if fit is not None else start


def _best_geometry(xy_a: FloatArray, xy_b: FloatArray, *, threshold: float) -> _Geometry | None:
    found = [
        _triangulated(R, t, xy_a, xy_b, threshold)
        for R, t in [
            *_from_essential(xy_a, xy_b, threshold),
            *_from_homography(xy_a, xy_b, threshold),
        ]
    ]
    found.sort(key=lambda g: -int(g.good.sum()))
    if not found or found[0].good.sum() < max(_LEAST_POINTS, 0.5 * len(xy_a)):
        return None
    best = found[0]
    for other in found[1:]:
        turn = best.T_cam_world.R @ other.T_cam_world.R.T
        differs = np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1)) > np.radians(1.0)
        differs |= float(best.T_cam_world.t @ other.T_cam_world.t) < np.cos(np.radians(10.0))
        if differs and other.good.sum() > 0.9 * best.good.sum():
            return None  # two-fold: more motion will tell
    return best


def _turn_residual(xy_a: FloatArray, xy_b: FloatArray) -> float:
    """Return the upper quartile of what a pure turn of the camera leaves of the motion.

    Two-view geometry invents a baseline for a turn; what a turn explains holds no depth.
    """
    rays_a, rays_b = (np.column_stack([xy, np.ones(len(xy))]) for xy in (xy_a, xy_b))
    rays_a /= np.linalg.norm(rays_a, axis=1, keepdims=True)
    rays_b /= np.linalg.norm(rays_b, axis=1, keepdims=True)
    weight = np.ones(len(rays_a))
    residual = weight
    for _ in range(4):
        left, _, right = np.linalg.svd((rays_b * weight[:, None]).T @ rays_a)
        R = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
        residual = np.linalg.norm(rays_a @ R.T - rays_b, axis=1)
        weight = 1.0 / (1.0 + (residual / (float(np.median(residual)) + 1e-9)) ** 2)
    return float(np.quantile(residual, 0.75))


def _from_essential(
    xy_a: FloatArray, xy_b: FloatArray, threshold: float
) -> list[tuple[FloatArray, FloatArray]]:
    found, mask = cv2.findEssentialMat(xy_a, xy_b, np.eye(3), cv2.RANSAC, 0.999, threshold, 500)
    essential = np.asarray(found, dtype=np.float64).reshape(-1, 3)
    if len(essential) < 3:
        return []
    _, R, t, _ = cv2.recoverPose(essential[:3], xy_a, xy_b, np.eye(3), mask=mask)
    return [(_floats(R), _floats(t).ravel())]


def _from_homography(
    xy_a: FloatArray, xy_b: FloatArray, threshold: float
) -> list[tuple[FloatArray, FloatArray]]:
    H, _ = cv2.findHomography(xy_a, xy_b, cv2.RANSAC, threshold, maxIters=500)
    if H is None:
        return []
    _, rotations, translations, _ = cv2.decomposeHomographyMat(H, np.eye(3))
    poses = []
    for R, t in zip(rotations, translations, strict=True):
        length = float(np.linalg.norm(t))
        if length > 1e-6:
            poses.append((_floats(R), _floats(t).ravel() / length))
    return poses


def _floats(values: object) -> FloatArray:
    return np.asarray(values, dtype=np.float64)


def _triangulated(
    R: FloatArray, t: FloatArray, xy_a: FloatArray, xy_b: FloatArray, threshold: float
) -> _Geometry:
    T: Pose[Cam, World] = Pose(R=R, t=t)
    homogeneous = cv2.triangulatePoints(np.eye(3, 4), T.matrix[:3], xy_a.T, xy_b.T)
    w = np.where(np.abs(homogeneous[3]) < 1e-9, 1e-9, homogeneous[3])
    points = np.asarray((homogeneous[:3] / w).T, dtype=np.float64)
    in_b = T.transform(points)
    good = (points[:, 2] > 0.1) & (in_b[:, 2] > 0.1) & (points[:, 2] < 1e3)
    with np.errstate(divide="ignore", invalid="ignore"):
        good &= np.linalg.norm(points[:, :2] / points[:, 2:] - xy_a, axis=1) < threshold
        good &= np.linalg.norm(in_b[:, :2] / in_b[:, 2:] - xy_b, axis=1) < threshold
    centre = T.inverse().t
    a, b = points[good], points[good] - centre
    cosine = (a * b).sum(axis=1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
    angles = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    parallax = float(np.median(angles)) if len(angles) else 0.0
    return _Geometry(T_cam_world=T, points_world=points, good=good, parallax_deg=parallax)
