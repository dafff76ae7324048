"""When a frame becomes a keyframe, and what mapping is told of it."""

import numpy as np

from gazemap.geometry.arrays import FloatArray, ImageArray, IntArray
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.live.bootstrap import Start
from gazemap.slam.live.config import LiveConfig
from gazemap.slam.live.corners import find_corners
from gazemap.slam.live.messages import KeyframeNote, MapUpdate, StartNote
from gazemap.slam.live.patches import Pyramid
from gazemap.slam.live.pose_tracker import FramePose, PoseTracker

_FLOW_START_SIGMA_PX = 1.0
# A corner's patch is predicted from a guessed depth, so it is found a little worse than a point's.
_CANDIDATE_SIGMA_FACTOR = 1.3


class Notes:
    """Numbers points and keyframes, and writes the notes to mapping."""

    def __init__(self, config: LiveConfig) -> None:
        """Start counting."""
        self._config = config
        self._next_id = 0
        self._next_keyframe = 0
        self._probe_ids: IntArray = np.empty(0, np.int64)

    def start_after(self, update: MapUpdate) -> None:
        """Count on from a map that was loaded."""
        if len(update.landmarks):
            self._next_id = max(self._next_id, int(update.landmarks.ids[-1]) + 1)
        self._next_keyframe = max(self._next_keyframe, update.keyframe_id + 1)

    def start(self, start: Start, *, map_id: int) -> StartNote:
        """Return the note of a new map."""
        ids = self._new_ids(len(start.views[0].uv_px))
        none, nowhere = np.empty(0, np.int64), np.empty((0, 2))
        notes = [
            KeyframeNote(
                keyframe_id=self._new_keyframe_id(),
                t_ns=view.t_ns,
                grey=view.grey,
                T_cam_world=view.T_cam_world,
                twist=np.zeros(6),
                ids=ids if n > 0 else none,
                uv_px=view.uv_px if n > 0 else nowhere,
                sigma_px=np.full(len(ids) if n > 0 else 0, _FLOW_START_SIGMA_PX),
                vanished_ids=none,
                born_ids=ids if n == 0 else none,
                born_uv_px=view.uv_px if n == 0 else nowhere,
            )
            for n, view in enumerate(start.views)
        ]
        return StartNote(map_id=map_id, keyframes=tuple(notes))

    def keyframe(
        self,
        poses: PoseTracker,
        found: FramePose,
        *,
        grey: ImageArray,
        twist: FloatArray,
        t_ns: int,
    ) -> KeyframeNote:
        """Return the note of a keyframe; its new corners become candidates.

        Mapping is told nothing of what the mask of moving things covers. New corners there are
        probes: they are followed until the next keyframe, to know what moves.
        """
        pyramid = Pyramid.of(grey)
        T_cam_world: Pose[Cam, World] = found.fit.T_cam_world
        ids, uv_px = poses.candidates.aligned(pyramid, T_cam_world)
        fine = ~poses.moving.covers(uv_px) & ~np.isin(ids, self._probe_ids)
        ids, uv_px = ids[fine], uv_px[fine]
        poses.candidates.keep(np.isin(poses.candidates.ids, ids))
        still = ~poses.moving.covers(found.uv_px)
        rows = found.rows[still]
        room = self._config.front_end.candidates - len(poses.candidates)
        born_px = find_corners(grey, np.concatenate([found.uv_px, uv_px]), count=room)
        born_ids = self._new_ids(len(born_px))
        is_probe = poses.moving.covers(born_px)
        self._probe_ids = born_ids[is_probe]
        poses.candidates.add(
            born_ids,
            born_px,
            pyramid=pyramid,
            T_world_cam=T_cam_world.inverse(),
            depth=depth_of(poses, found),
        )
        sigma_px = self._config.front_end.patch_sigma_px
        spread = np.repeat([1.0, _CANDIDATE_SIGMA_FACTOR], [len(rows), len(ids)])
        return KeyframeNote(
            keyframe_id=self._new_keyframe_id(),
            t_ns=t_ns,
            grey=grey,
            T_cam_world=T_cam_world,
            twist=twist,
            ids=np.concatenate([poses.landmarks.ids[rows], ids]),
            uv_px=np.concatenate([found.uv_px[still], uv_px]),
            sigma_px=sigma_px * spread,
            vanished_ids=poses.vanished_ids(),
            born_ids=born_ids[~is_probe],
            born_uv_px=born_px[~is_probe],
            readout_s=poses.readout_s,
        )

    def _new_ids(self, count: int) -> IntArray:
        self._next_id += count
        return np.arange(self._next_id - count, self._next_id)

    def _new_keyframe_id(self) -> int:
        self._next_keyframe += 1
        return self._next_keyframe - 1


def depth_of(poses: PoseTracker, found: FramePose) -> float:
    """Return the median distance of the points that a frame saw."""
    points = poses.landmarks.points_world[found.rows]
    away = points - found.fit.T_cam_world.inverse().t
    return float(np.median(np.linalg.norm(away, axis=1)))


def distance_from_keyframes(
    update: MapUpdate, T_world_cam: Pose[World, Cam], *, depth: float
) -> float:
    """Return how far a pose is from all keyframes: the way over the depth plus half the turn."""
    away = np.linalg.norm(update.keyframe_centres_world - T_world_cam.t, axis=1) / depth
    cosine = update.keyframe_axes_world @ T_world_cam.R[:, 2]
    return float((away + 0.5 * np.arccos(np.clip(cosine, -1.0, 1.0))).min())
