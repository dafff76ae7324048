"""Fixations as they are made: cast at once, and again when the world turns out to be otherwise."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from gazemap.gaze.cast import FixationCaster, PosedOverhead, in_scene_image
from gazemap.gaze.config import FixationConfig, GazeNoise, OffsetConfig
from gazemap.gaze.detect import detect_fixations
from gazemap.gaze.offset import estimate_gaze_offset
from gazemap.geometry.align import Similarity
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.ports import SurfaceQuery
from gazemap.session.gaze_camera import GazeCamera
from gazemap.slam.live.following import KeyframeMoves
from gazemap.types.fixation import Fixation3D, GazeOffset
from gazemap.types.scene import SceneObject
from gazemap.types.session import Fixation, GazeSample, GazeSamples
from gazemap.types.tracking import Scale, Tracked, Trajectory

# How far a published point must move before it is published again.
_MOVED_M: Final = 0.003
_KEPT_FIXATIONS: Final = 500
_KEPT_POSES: Final = 600
_GAZE_WINDOW_NS: Final = 4_000_000_000
_GAZE_STEP_NS: Final = 250_000_000
# A span that ends so near to the newest sample may still grow, even after a blink.
_SETTLED_NS: Final = 400_000_000
_OFFSET_EVERY: Final = 5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Look:
    """A fixation with the pose it was made from and what was published of it."""

    fixation: Fixation
    T_world_cam: Pose[World, Cam] | None
    cast: Fixation3D
    map_id: int


class RecentPath:
    """The head camera's last poses."""

    def __init__(self) -> None:
        self._tracked: deque[Tracked] = deque(maxlen=_KEPT_POSES)
        self.last_ns = 0

    def add(self, tracked: Tracked) -> None:
        """Take in the next pose."""
        self._tracked.append(tracked)

    def transform(
        self, S_new_old: Similarity[World, World], *, old_map_id: int, map_id: int
    ) -> None:
        """Move the poses of a map that was re-optimised, maybe into another one's world."""
        moved = [
            replace(each, T_world_cam=S_new_old.transform_pose(each.T_world_cam), map_id=map_id)
            if each.map_id == old_map_id
            else each
            for each in self._tracked
        ]
        self._tracked = deque(moved, maxlen=_KEPT_POSES)

    def map_id_at(self, t_ns: int) -> int:
        """Return the map that was tracked at a time."""
        later = (each.map_id for each in self._tracked if each.t_ns >= t_ns)
        return next(later, self._tracked[-1].map_id if self._tracked else 0)

    def trajectory(self, scale: Scale) -> Trajectory:
        """Return the poses as a path."""
        return Trajectory.from_outcomes(list(self._tracked), scale=scale)


class LiveLooks:
    """Casts fixations when their pose is known; corrects what was published, never silently."""

    def __init__(
        self,
        camera: Camera,
        *,
        noise: GazeNoise,
        offset: OffsetConfig,
        eyes: GazeCamera | None = None,
    ) -> None:
        self._camera, self._eyes = camera, eyes
        self._noise, self._offset_config = noise, offset
        self._waiting: deque[Fixation] = deque()
        self._looks: dict[int, Look] = {}
        self._since_estimate = 0
        self.overhead: PosedOverhead | None = None
        self.offset = GazeOffset(
            azimuth_rad=0.0,
            elevation_rad=0.0,
            azimuth_sigma_rad=float(np.radians(offset.unknown_sigma_deg)),
            elevation_sigma_rad=float(np.radians(offset.unknown_sigma_deg)),
            is_applied=False,
        )

    def add(self, fixation: Fixation) -> None:
        """Take in a fixation that has ended."""
        self._waiting.append(fixation)

    def cast_due(
        self, path: RecentPath, surface: SurfaceQuery, *, scale: Scale
    ) -> list[Fixation3D]:
        """Cast the fixations whose mid-time the path has passed."""
        if not self._waiting or self._waiting[0].mid_ns > path.last_ns:
            return []
        caster, trajectory = self._caster(surface), path.trajectory(scale)
        done = []
        while self._waiting and self._waiting[0].mid_ns <= path.last_ns:
            fixation = self._waiting.popleft()
            T_world_cam = trajectory.at(fixation.mid_ns)
            cast = self._cast(caster, fixation, T_world_cam)
            map_id = path.map_id_at(fixation.mid_ns)
            look = Look(fixation=fixation, T_world_cam=T_world_cam, cast=cast, map_id=map_id)
            self._looks[fixation.fixation_id] = look
            done.append(cast)
        self._since_estimate += len(done)
        for stale in list(self._looks)[:-_KEPT_FIXATIONS]:
            del self._looks[stale]
        return done

    def recast(self, surface: SurfaceQuery, only: set[int] | None = None) -> list[Fixation3D]:
        """Cast everything or some anew; return what is no longer where it was published."""
        caster, changed = self._caster(surface), []
        keys = self._looks.keys() if only is None else only
        for key in sorted(keys):
            look = self._looks[key]
            cast = self._cast(caster, look.fixation, look.T_world_cam)
            if _differs(cast, look.cast):
                self._looks[key] = replace(look, cast=cast)
                changed.append(cast)
        return changed

    def follow(self, keyframes: KeyframeMoves) -> set[int]:
        """Move looks with the map that they were made in; return which have moved."""
        moved_keys = set()
        for key, look in self._looks.items():
            if look.T_world_cam is None or look.map_id != keyframes.old_map_id:
                continue
            moved = keyframes.moved(look.fixation.mid_ns, look.T_world_cam)
            if moved is not None:
                moved_keys.add(key)
            T_world_cam = look.T_world_cam if moved is None else moved
            self._looks[key] = replace(look, T_world_cam=T_world_cam, map_id=keyframes.map_id)
        return moved_keys

    def estimate_offset(self, objects: Sequence[SceneObject], *, scale: Scale) -> bool:
        """Estimate the gaze error anew from time to time; return whether it changed."""
        if self._since_estimate < _OFFSET_EVERY:
            return False
        self._since_estimate = 0
        posed = {
            look.fixation.mid_ns: look
            for look in self._looks.values()
            if look.T_world_cam is not None
        }
        outcomes = [
            Tracked(t_ns=t_ns, T_world_cam=posed[t_ns].T_world_cam)  # type: ignore[arg-type]
            for t_ns in sorted(posed)
        ]
        trajectory = Trajectory.from_outcomes(outcomes, scale=scale)
        estimate = estimate_gaze_offset(
            tuple(posed[t_ns].fixation for t_ns in sorted(posed)),
            trajectory=carried(trajectory, self._eyes),
            camera=self._camera if self._eyes is None else self._eyes.camera,
            objects=tuple(objects),
            config=self._offset_config,
        )
        before, self.offset = self.offset, estimate
        return before.is_applied or estimate.is_applied

    def _caster(self, surface: SurfaceQuery) -> FixationCaster:
        return FixationCaster(
            camera=self._camera if self._eyes is None else self._eyes.camera,
            surface=surface,
            offset=self.offset,
            noise=self._noise,
        )

    def _cast(
        self, caster: FixationCaster, fixation: Fixation, T_world_cam: Pose[World, Cam] | None
    ) -> Fixation3D:
        """Cast from the camera on whose images gaze is; pixels are the head camera's."""
        if self._eyes is None:
            return caster.cast(fixation, T_world_cam, overhead=self.overhead)
        if T_world_cam is None:
            cast = caster.cast(fixation, None, overhead=self.overhead)
        else:
            T = T_world_cam @ self._eyes.T_cam_gaze
            cast = caster.cast(fixation, Pose(R=T.R, t=T.t), overhead=self.overhead)
        return in_scene_image(cast, T_world_cam, self._camera)


def carried(trajectory: Trajectory, eyes: GazeCamera | None) -> Trajectory:
    """Return the path of the camera on whose images gaze is."""
    return trajectory if eyes is None else trajectory.carrying(eyes.T_cam_gaze)


def _differs(new: Fixation3D, old: Fixation3D) -> bool:
    if new.object_id != old.object_id or new.hit is not old.hit:
        return True
    if new.point_world is None or old.point_world is None:
        return False
    return float(np.linalg.norm(new.point_world - old.point_world)) > _MOVED_M


class LiveFixations:
    """Detects fixations in a stream of gaze with the detector that rebuilds use."""

    def __init__(
        self, camera: Camera, config: FixationConfig, eyes: GazeCamera | None = None
    ) -> None:
        self._camera, self._config = camera if eyes is None else eyes.camera, config
        self._eyes = eyes
        self._samples: deque[GazeSample] = deque()
        self._last_look_ns = 0
        self._emitted_end_ns = 0
        self._count = 0

    def add(self, sample: GazeSample, path: RecentPath, *, scale: Scale) -> list[Fixation]:
        """Take in a sample; return the fixations that are seen to have ended."""
        if self._samples and sample.t_ns <= self._samples[-1].t_ns:
            return []
        self._samples.append(sample)
        while sample.t_ns - self._samples[0].t_ns > _GAZE_WINDOW_NS:
            self._samples.popleft()
        if sample.t_ns - self._last_look_ns < _GAZE_STEP_NS:
            return []
        self._last_look_ns = sample.t_ns
        return self._ended(sample.t_ns, path, scale=scale)

    def _ended(self, now_ns: int, path: RecentPath, *, scale: Scale) -> list[Fixation]:
        trajectory = path.trajectory(scale)
        found = detect_fixations(
            _table(self._samples),
            self._camera,
            carried(trajectory, self._eyes) if len(trajectory) > 1 else None,
            (),
            self._config,
        )
        ended = []
        for each in found:
            if each.start_ns > self._emitted_end_ns and each.end_ns < now_ns - _SETTLED_NS:
                self._count += 1
                self._emitted_end_ns = each.end_ns
                ended.append(replace(each, fixation_id=self._count))
        return ended


def _table(samples: Sequence[GazeSample] | deque[GazeSample]) -> GazeSamples:
    return GazeSamples(
        t_ns=np.array([s.t_ns for s in samples], dtype=np.int64),
        uv_px=np.array([(s.u_px, s.v_px) for s in samples], dtype=np.float64).reshape(-1, 2),
        worn=np.array([s.worn for s in samples], dtype=np.bool_),
        blink=np.array([s.blink for s in samples], dtype=np.bool_),
    )
