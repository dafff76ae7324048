"""The pose of a frame in a known map: optical flow first, then the fixed patches."""

from dataclasses import dataclass, replace

import numpy as np

from gazemap.geometry.align import Similarity
from gazemap.geometry.arrays import FloatArray, ImageArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.live.candidates import Candidates
from gazemap.slam.live.config import FrontEndConfig
from gazemap.slam.live.flow import follow
from gazemap.slam.live.glance import turn_between
from gazemap.slam.live.landmarks import Landmarks, View, see, spread
from gazemap.slam.live.messages import MapUpdate
from gazemap.slam.live.motion import Motion, twist_between
from gazemap.slam.live.patches import Pyramid, align_patches
from gazemap.slam.live.places import PlaceIndex
from gazemap.slam.live.refine import PoseFit, PoseProblem, refine_pose
from gazemap.slam.live.shutter import ShutterWatch
from gazemap.slam.moving import NO_VOTES, Followed, MovingMask, Votes, votes_of
from gazemap.types.tracking import LostReason

_INLIER_SIGMAS = 4.0
_WIDEST_INLIER_SIGMAS = 12.0
_FLOW_REACH_PX = 3.0
_PRIOR_REACH_PX = 6.0
# Of the points that should be seen after relocalising; a wrong place finds hardly any.
_RELOCALISED_SHARE = 0.25
_COVERED_DOUBT = 4.0
_SOUGHT_LONG = 60
_HARDLY_FOUND = 0.1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FramePose:
    """A frame's pose and what it rests on.

    Attributes:
        fit: the pose.
        rows: (N,) of the landmarks that fit.
        uv_px: (N, 2) where they are.
        visible_count: landmarks that were looked for.
        votes: which corners moved with the map since the frame before, and which did not.
    """

    fit: PoseFit
    rows: IntArray
    uv_px: FloatArray
    visible_count: int
    votes: Votes = NO_VOTES

    @property
    def is_sure(self) -> bool:
        """Whether enough of the points that should be seen were; a wrong place has hardly any."""
        return len(self.rows) >= _RELOCALISED_SHARE * self.visible_count


class PoseTracker:
    """Holds the map as tracking sees it, and the last frame."""

    def __init__(self, camera: Camera, config: FrontEndConfig) -> None:
        """Start without a map."""
        self._camera, self._config = camera, config
        self._focal_px = float(camera.K[0, 0])
        self.landmarks = Landmarks.none()
        self.candidates = Candidates(camera)
        self._places = PlaceIndex(camera)
        self._shutter = ShutterWatch(camera)
        self.moving = MovingMask(width_px=camera.width_px, height_px=camera.height_px)
        self._followed: Followed | None = None
        self._flow_ids: IntArray = np.empty(0, np.int64)
        self._flow_uv_px: FloatArray = np.empty((0, 2))
        self._grey: ImageArray | None = None
        # How often each landmark was looked for and found.
        self._sought: IntArray = np.empty(0, np.int64)
        self._hits: IntArray = np.empty(0, np.int64)

    @property
    def readout_s(self) -> float | None:
        """The read-out time as it was told, or as far as it has been found."""
        return self._shutter.camera.readout_s

    def take(self, update: MapUpdate) -> None:
        """Use a new state of the map; references of known points are kept."""
        fresh = update.landmarks
        rows, known = self.landmarks.rows_of(fresh.ids)
        zero = np.zeros(len(fresh.ids), np.int64)
        references = np.empty((len(fresh.ids), *fresh.references.shape[1:]), np.uint8)
        references[known] = self.landmarks.references[rows[known]]
        references[np.searchsorted(fresh.ids, update.new_ids)] = fresh.references
        self.landmarks = Landmarks(
            ids=fresh.ids,
            points_world=fresh.points_world,
            step_world=fresh.step_world,
            facing_world=fresh.facing_world,
            view_count=fresh.view_count,
            references=references,
        )
        self._sought = np.where(known, self._sought[rows], 0) if len(self._sought) else zero
        self._hits = np.where(known, self._hits[rows], 0) if len(self._hits) else zero.copy()
        mapped = np.isin(self.candidates.ids, fresh.ids)
        self._flow_ids = np.concatenate([self._flow_ids, self.candidates.ids[mapped]])
        self._flow_uv_px = np.concatenate([self._flow_uv_px, self.candidates.uv_px[mapped]])
        self.candidates.keep(~mapped)

    def transform(self, S_new_old: Similarity[World, World]) -> None:
        """Follow the map into its new world; landmarks come with the update."""
        self.candidates.transform(S_new_old)

    def pose(
        self, grey: ImageArray, pyramid: Pyramid, motion: Motion, t_ns: int
    ) -> FramePose | LostReason:
        """Return the frame's pose; on success the frame becomes the last one."""
        found = self._pose_near(motion.predict(t_ns), grey, pyramid, motion, t_ns)
        if not isinstance(found, FramePose):
            # They have moved on to this frame while the last good one stays.
            self.candidates.keep(np.zeros(len(self.candidates), bool))
            if self._grey is not None:
                turn = turn_between(self._grey, grey, self._camera)
                turned = self._pose_near(turn @ motion.T_cam_world, grey, pyramid, motion, t_ns)
                if isinstance(turned, FramePose) and turned.is_sure:
                    found = turned
        if isinstance(found, FramePose):
            self._remember(grey, found)
            found = replace(found, votes=self._votes(motion.T_cam_world, found.fit.T_cam_world))
        return found

    def _pose_near(
        self,
        predicted: Pose[Cam, World],
        grey: ImageArray,
        pyramid: Pyramid,
        motion: Motion,
        t_ns: int,
    ) -> FramePose | LostReason:
        """Return the frame's pose, looked for around a predicted one."""
        T_cam_world, reach_px = self._flow_pose(grey, motion, predicted)
        twist = twist_between(motion.T_cam_world, T_cam_world, (t_ns - motion.t_ns) * 1e-9)
        return self._aligned_pose(pyramid, T_cam_world, reach_px, twist=twist)

    def vanished_ids(self) -> IntArray:
        """Return the landmarks that have moved away, or never were what they seemed."""
        gone = (self._sought > _SOUGHT_LONG) & (self._hits < _HARDLY_FOUND * self._sought)
        return self.landmarks.ids[gone]

    def forget_frame(self) -> None:
        """Forget the last frame and its corners: the map is another one."""
        self._grey = None
        self.candidates.keep(np.zeros(len(self.candidates), bool))
        self.moving.forget()

    def relocalise(self, grey: ImageArray, pyramid: Pyramid) -> FramePose | LostReason:
        """Return the pose from the map alone; on success the frame becomes the last one."""
        self._places.take(self.landmarks)
        place = self._places.recognise(grey)
        if place is None:
            return LostReason.FEW_FEATURES
        found = self._aligned_pose(pyramid, place.T_cam_world, _PRIOR_REACH_PX, twist=np.zeros(6))
        if isinstance(found, FramePose):
            # Once more from the better pose, which lets more points be found.
            again = self._aligned_pose(
                pyramid, found.fit.T_cam_world, _FLOW_REACH_PX, twist=np.zeros(6)
            )
            found = again
        if isinstance(found, FramePose):
            if not found.is_sure:
                return LostReason.FEW_INLIERS
            self.candidates.keep(np.zeros(len(self.candidates), bool))
            self.moving.forget()
            self._remember(grey, found)
        return found

    def _flow_pose(
        self, grey: ImageArray, motion: Motion, predicted: Pose[Cam, World]
    ) -> tuple[Pose[Cam, World], float]:
        """Return the pose by optical flow, or the predicted one, and how far it may be off."""
        self._followed = None
        if self._grey is None:
            return predicted, _PRIOR_REACH_PX
        rows, known = self.landmarks.rows_of(self._flow_ids)
        rows, before_px = rows[known], self._flow_uv_px[known]
        points = self.landmarks.points_world[rows]
        moved = self._camera.project(predicted.transform(points))
        moved -= self._camera.project(motion.T_cam_world.transform(points))
        shift = np.concatenate(
            [np.nan_to_num(moved), self.candidates.shift(motion.T_cam_world, predicted)]
        )
        start = np.concatenate([before_px, self.candidates.uv_px])
        uv_px, found = follow(self._grey, grey, start, start + shift, self._config)
        count = len(rows)
        depth = motion.T_cam_world.transform(points)[:, 2]
        depth = np.concatenate([depth, np.full(len(start) - count, np.nan)])
        self._followed = Followed(before_px=start[found], after_px=uv_px[found], depth=depth[found])
        self.candidates.uv_px = uv_px[count:]
        self.candidates.keep(found[count:])
        seen = found[:count]
        twist = motion.twist
        problem = self._problem(
            points[seen], uv_px[:count][seen], self._config.flow_sigma_px, twist
        )
        fit = refine_pose(predicted, problem)
        if fit is None or fit.inliers(_INLIER_SIGMAS).sum() < self._config.least_inliers:
            return predicted, _PRIOR_REACH_PX
        return fit.T_cam_world, _FLOW_REACH_PX

    def _votes(self, before: Pose[Cam, World], after: Pose[Cam, World]) -> Votes:
        """Return how what was followed into this frame moved."""
        if self._followed is None:
            return NO_VOTES
        return votes_of(self._followed, self._camera, T_after_before=after @ before.inverse())

    def _aligned_pose(
        self,
        pyramid: Pyramid,
        T_cam_world: Pose[Cam, World],
        reach_px: float,
        *,
        twist: FloatArray,
    ) -> FramePose | LostReason:
        view = self._chosen(T_cam_world)
        uv_px, correlation = align_patches(
            pyramid, self.landmarks.references[view.rows], view.from_image, view.uv_px,
            coarse=reach_px > _FLOW_REACH_PX, reach_px=reach_px,
        )  # fmt: skip
        good = correlation > self._config.least_correlation
        rows, uv_px = view.rows[good], uv_px[good]
        if len(rows) < self._config.least_inliers:
            return LostReason.FEW_FEATURES
        # What is under the mask may be wrong, and may be all there is.
        doubt = np.where(self.moving.covers(uv_px), _COVERED_DOUBT, 1.0)
        problem = self._problem(
            self.landmarks.points_world[rows], uv_px, doubt * self._config.patch_sigma_px, twist
        )
        fit = refine_pose(T_cam_world, problem)
        if fit is None:
            return LostReason.DIVERGED
        fit = replace(fit, error=fit.error * doubt)
        self._shutter.observe(fit.T_cam_world, problem, uv_px[:, 1])
        # Where all points scatter more, under blur or an unknown shutter, more of it is no outlier.
        scatter = 3.0 * float(np.median(fit.error))
        inlier = fit.inliers(float(np.clip(scatter, _INLIER_SIGMAS, _WIDEST_INLIER_SIGMAS)))
        self._sought[view.rows] += 1
        self._hits[rows[inlier]] += 1
        if inlier.sum() < max(self._config.least_inliers, 0.3 * len(rows)):
            return LostReason.FEW_INLIERS
        return FramePose(
            fit=fit, rows=rows[inlier], uv_px=uv_px[inlier], visible_count=len(view.rows)
        )

    def _chosen(self, T_cam_world: Pose[Cam, World]) -> View:
        """Return the landmarks in view, thinned to an even spread of the best known."""
        marks = self.landmarks
        view = see(
            self._camera, T_cam_world, marks.points_world, marks.step_world, marks.facing_world
        )
        chosen = spread(
            view.uv_px, self._rank(view.rows),
            count=self._config.aligned_landmarks, camera=self._camera,
        )  # fmt: skip
        return View(
            rows=view.rows[chosen], uv_px=view.uv_px[chosen], from_image=view.from_image[chosen]
        )

    def _rank(self, rows: IntArray) -> FloatArray:
        """Return how much landmarks (N,) are worth: seen by many keyframes, found when sought."""
        share = (self._hits[rows] + 3.0) / (self._sought[rows] + 3.0)
        rank: FloatArray = self.landmarks.view_count[rows] * share**2
        return rank

    def _problem(
        self,
        points_world: FloatArray,
        uv_px: FloatArray,
        sigma_px: float | FloatArray,
        twist: FloatArray,
    ) -> PoseProblem:
        return PoseProblem(
            points_world=points_world,
            xy=self._camera.normalize(uv_px),
            sigma=np.broadcast_to(sigma_px / self._focal_px, (len(uv_px),)),
            dt_s=self._shutter.camera.row_delay_ns(uv_px[:, 1]) * 1e-9,
            twist=twist,
        )

    def _remember(self, grey: ImageArray, found: FramePose) -> None:
        chosen = spread(
            found.uv_px, self.landmarks.view_count[found.rows].astype(np.float64),
            count=self._config.flow_landmarks, camera=self._camera,
        )  # fmt: skip
        self._grey = grey
        self._flow_ids = self.landmarks.ids[found.rows[chosen]]
        self._flow_uv_px = found.uv_px[chosen]
