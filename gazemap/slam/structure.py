"""A map in the making: posed keyframes, points, and which keyframe saw which."""

import cv2
import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, IntArray
from gazemap.slam.bundle import BundleProblem, adjust
from gazemap.slam.pose_solver import PoseFit, fit_pose

_OUTLIER_PX = 3.0


class Structure:
    """Keyframes and points in the map's frame; tracks without a point wait to be triangulated.

    Attributes:
        R_cam_map: (K, 3, 3) of the keyframes.
        t_cam_map: (K, 3).
        is_posed: (K,).
        points_map: (T, 3) one a track.
        has_point: (T,).
        keyframe: (M,) of each view.
        track: (M,) of each view.
        flat: (M, 2) x/z, y/z of each view.
        is_valid: (M,) views that agree with the map, or were not judged yet.
    """

    def __init__(
        self, *, keyframe: IntArray, track: IntArray, flat: FloatArray, focal_px: float
    ) -> None:
        """Take the views, sorted by keyframe; nothing is posed yet."""
        keyframe_count = int(keyframe.max()) + 1 if len(keyframe) else 0
        track_count = int(track.max()) + 1 if len(track) else 0
        self.keyframe, self.track, self.flat, self.focal_px = keyframe, track, flat, focal_px
        self.is_valid: BoolArray = np.ones(len(track), dtype=np.bool_)
        self.R_cam_map = np.tile(np.eye(3), (keyframe_count, 1, 1))
        self.t_cam_map = np.zeros((keyframe_count, 3))
        self.is_posed: BoolArray = np.zeros(keyframe_count, dtype=np.bool_)
        self.points_map = np.zeros((track_count, 3))
        self.has_point: BoolArray = np.zeros(track_count, dtype=np.bool_)
        self._start = np.searchsorted(keyframe, np.arange(keyframe_count + 1))

    def views(self, k: int) -> slice:
        """Return where the views of keyframe k are."""
        return slice(int(self._start[k]), int(self._start[k + 1]))

    def set_pose(self, k: int, R_cam_map: FloatArray, t_cam_map: FloatArray) -> None:
        """Pose keyframe k."""
        self.R_cam_map[k], self.t_cam_map[k], self.is_posed[k] = R_cam_map, t_cam_map, True

    def known_views(self, k: int) -> IntArray:
        """Return the views of keyframe k whose tracks have points."""
        rows = np.arange(self._start[k], self._start[k + 1])
        return rows[self.has_point[self.track[rows]] & self.is_valid[rows]]

    def known_counts(self) -> IntArray:
        """Return how many views of each keyframe (K,) have points."""
        known = self.has_point[self.track] & self.is_valid
        return np.bincount(self.keyframe[known], minlength=len(self.is_posed)).astype(np.int64)

    def residual_px(self) -> FloatArray:
        """Return how far each view (M,) is from its point; inf behind, NaN where not known."""
        known = self.is_posed[self.keyframe] & self.has_point[self.track]
        off = np.full(len(known), np.nan)
        rows = np.flatnonzero(known)
        off[rows] = self.residual_px_to(rows, self.track[rows])
        return off

    def residual_px_to(self, rows: IntArray, tracks: IntArray) -> FloatArray:
        """Return how far views (N,) are from the points of tracks (N,); inf behind."""
        keyframe = self.keyframe[rows]
        in_cam = np.einsum("nij,nj->ni", self.R_cam_map[keyframe], self.points_map[tracks])
        in_cam += self.t_cam_map[keyframe]
        with np.errstate(divide="ignore", invalid="ignore"):
            off = np.linalg.norm(in_cam[:, :2] / in_cam[:, 2:] - self.flat[rows], axis=1)
        off[in_cam[:, 2] < 1e-6] = np.inf
        return np.asarray(off * self.focal_px)

    def triangulate(self, *, min_parallax_rad: float) -> None:
        """Give points to the tracks that enough posed keyframes see from far enough apart."""
        wanted = self.is_posed[self.keyframe] & ~self.has_point[self.track] & self.is_valid
        rows = np.flatnonzero(wanted)
        if len(rows) == 0:
            return
        points, parallax = intersect_rays(
            self.R_cam_map[self.keyframe[rows]], self.t_cam_map[self.keyframe[rows]],
            self.flat[rows], group=self.track[rows], group_count=len(self.has_point),
        )  # fmt: skip
        fresh = (parallax > min_parallax_rad) & np.isfinite(points).all(axis=1)
        self.points_map[fresh], self.has_point[fresh] = points[fresh], True
        self._drop_bad_points(np.flatnonzero(fresh), worst_px=_OUTLIER_PX)

    def _drop_bad_points(self, tracks: IntArray, *, worst_px: float) -> None:
        """Take points back whose views, in the median or in all but one, miss them."""
        is_fresh = np.zeros(len(self.has_point), dtype=np.bool_)
        is_fresh[tracks] = True
        off = self.residual_px()
        rows = np.isfinite(off) | np.isinf(off)
        rows &= is_fresh[self.track] & self.is_valid
        good = np.bincount(self.track[rows & (off < worst_px)], minlength=len(self.has_point))
        every = np.bincount(self.track[rows], minlength=len(self.has_point))
        self.has_point[is_fresh & ((good < 2) | (good < 0.6 * every))] = False

    def locate(self, k: int, *, min_inliers: int) -> bool:
        """Pose keyframe k from the points it sees; return whether enough of them agree."""
        rows = self.known_views(k)
        if len(rows) < min_inliers:
            return False
        near, points = self.nearest_posed(k), self.points_map[self.track[rows]]
        fit = robust_pose(
            self.R_cam_map[near], self.t_cam_map[near], points_map=points,
            flat=self.flat[rows], focal_px=self.focal_px,
        )  # fmt: skip
        inliers = int(fit.inliers(_OUTLIER_PX / self.focal_px).sum())
        if inliers < max(min_inliers, 0.35 * len(rows)):
            return False
        self.set_pose(k, fit.R_cam_map, fit.t_cam_map)
        return True

    def nearest_posed(self, k: int) -> int:
        """Return the posed keyframe nearest in time to keyframe k."""
        posed = np.flatnonzero(self.is_posed)
        return int(posed[np.abs(posed - k).argmin()])

    def adjust(self, *, cauchy_px: float, iterations: int = 30) -> None:
        """Bundle-adjust all posed keyframes and points, then judge the views anew."""
        used = self.is_posed[self.keyframe] & self.has_point[self.track] & self.is_valid
        count = np.bincount(self.track[used], minlength=len(self.has_point))
        used &= count[self.track] >= 2
        posed, points = np.flatnonzero(self.is_posed), np.flatnonzero(count >= 2)
        rank_posed, rank_point = _ranks(posed, len(self.is_posed)), _ranks(points, len(count))
        solved = adjust(
            BundleProblem(
                R_cam_map=self.R_cam_map[posed],
                t_cam_map=self.t_cam_map[posed],
                points_map=self.points_map[points],
                camera_index=rank_posed[self.keyframe[used]],
                point_index=rank_point[self.track[used]],
                flat=self.flat[used],
                focal_px=self.focal_px,
                cauchy_px=cauchy_px,
                iterations=iterations,
            )
        )
        self.R_cam_map[posed], self.t_cam_map[posed] = solved.R_cam_map, solved.t_cam_map
        self.points_map[points] = solved.points_map
        self.judge(worst_px=_OUTLIER_PX)

    def judge(self, *, worst_px: float) -> None:
        """Mark the views that miss their points, and drop points that too few views support."""
        off = self.residual_px()
        known = ~np.isnan(off)
        self.is_valid[known] = off[known] < worst_px
        self._drop_bad_points(np.flatnonzero(self.has_point), worst_px=worst_px)
        self.is_valid[~self.has_point[self.track]] = True


def robust_pose(
    R_cam_map: FloatArray,
    t_cam_map: FloatArray,
    *,
    points_map: FloatArray,
    flat: FloatArray,
    focal_px: float,
) -> PoseFit:
    """Return the pose from a start nearby, or from a random-sample search where that fails."""
    cauchy = 1.0 / focal_px
    fit = fit_pose(R_cam_map, t_cam_map, points_map=points_map, flat=flat, cauchy=cauchy)
    if fit.inliers(_OUTLIER_PX / focal_px).mean() > 0.6:
        return fit
    found, rotvec, origin, _ = cv2.solvePnPRansac(
        points_map, flat, np.eye(3), None, iterationsCount=300,
        reprojectionError=_OUTLIER_PX / focal_px, flags=cv2.SOLVEPNP_EPNP,
    )  # fmt: skip
    if not found:
        return fit
    other = fit_pose(
        cv2.Rodrigues(rotvec)[0].astype(np.float64), origin.ravel().astype(np.float64),
        points_map=points_map, flat=flat, cauchy=cauchy,
    )  # fmt: skip
    radius = _OUTLIER_PX / focal_px
    return max(fit, other, key=lambda each: int(each.inliers(radius).sum()))


def intersect_rays(
    R_cam_map: FloatArray,
    t_cam_map: FloatArray,
    flat: FloatArray,
    *,
    group: IntArray,
    group_count: int,
) -> tuple[FloatArray, FloatArray]:
    """Return where the rays of each group meet best (G, 3), and their parallax in radians (G,).

    The point has the least sum of squared distances to the rays; parallax is that of the widest
    pair, as seen from the first ray of the group.

    Args:
        R_cam_map: (N, 3, 3) of each ray's camera.
        t_cam_map: (N, 3).
        flat: (N, 2) rays x/z, y/z.
        group: (N,) which point a ray belongs to.
        group_count: how many there are; those without rays get NaN.
    """
    ray = np.column_stack([flat, np.ones(len(flat))])
    ray /= np.linalg.norm(ray, axis=1, keepdims=True)
    ray_map = np.einsum("nji,nj->ni", R_cam_map, ray)
    centre = -np.einsum("nji,nj->ni", R_cam_map, t_cam_map)
    across = np.eye(3) - ray_map[:, :, None] * ray_map[:, None, :]  # (N, 3, 3)
    normal = np.zeros((group_count, 3, 3))
    target = np.zeros((group_count, 3))
    np.add.at(normal, group, across)
    np.add.at(target, group, np.einsum("nij,nj->ni", across, centre))
    first = np.full(group_count, -1)
    first[group[::-1]] = np.arange(len(group))[::-1]
    cosine = np.einsum("ni,ni->n", ray_map, ray_map[first[group]])
    parallax = np.zeros(group_count)
    np.maximum.at(parallax, group, np.arccos(np.clip(cosine, -1.0, 1.0)))
    points = np.full((group_count, 3), np.nan)
    solvable = parallax > 1e-4
    points[solvable] = np.linalg.solve(normal[solvable], target[solvable][..., None])[..., 0]
    return points, parallax


def _ranks(chosen: IntArray, count: int) -> IntArray:
    ranks = np.full(count, -1, dtype=np.int64)
    ranks[chosen] = np.arange(len(chosen))
    return ranks
