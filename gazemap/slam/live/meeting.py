"""When a keyframe is recognised in another map, or in a part of its own that it lost sight of."""

import numpy as np

from gazemap.geometry.align import Similarity, fit_similarity_of_poses
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.live.landmarks import Landmarks
from gazemap.slam.live.mapdata import Keyframe, SparseMap
from gazemap.slam.live.places import Place, PlaceIndex
from gazemap.types.tracking import Scale

_LEAST_KEYFRAMES = 3
# A map drifts: what was recognised long ago agrees less.
_LATEST_KEYFRAMES = 5
_LEAST_INLIERS = 30
# The baseline of the keyframes over the depth, below which their scale says nothing.
_LEAST_BASELINE = 0.05
_WORST_RESIDUAL = 0.12


class Recognitions:
    """The keyframes that were recognised elsewhere, and the similarity that they agree on."""

    def __init__(self, camera: Camera) -> None:
        """Start without any."""
        self._index = PlaceIndex(camera)
        self._poses: dict[int, Pose[World, Cam]] = {}

    def recognise(self, landmarks: Landmarks, keyframe: Keyframe) -> Place | None:
        """Look for a keyframe among points and remember where it was found."""
        if keyframe.pyramid is None:
            return None
        self._index.take(landmarks)
        place = self._index.recognise(keyframe.pyramid.full)
        if place is None or len(place.ids) < _LEAST_INLIERS:
            return None
        self._poses[keyframe.keyframe_id] = place.T_cam_world.inverse()
        return place

    def forget(self) -> None:
        """Forget all keyframes."""
        self._poses = {}

    def agreed(self, present: SparseMap, *, depth: float) -> Similarity[World, World] | None:
        """Return `S_here_present` that most of the latest agree on; the worst are left out."""
        ids = [k for k in self._poses if k in present.keyframes][-_LATEST_KEYFRAMES:]
        there = [present.keyframes[k].T_cam_world.inverse() for k in ids]
        here = [self._poses[k] for k in ids]
        while len(here) >= _LEAST_KEYFRAMES:
            centres = np.array([T.t for T in here])
            spread = float(np.linalg.norm(centres - centres.mean(axis=0), axis=1).max())
            S: Similarity[World, World] | None = fit_similarity_of_poses(there, here)
            if S is None or spread < _LEAST_BASELINE * depth:
                return None
            moved = S.transform(np.array([T.t for T in there]))
            off = np.linalg.norm(moved - centres, axis=1)
            if off.max() < _WORST_RESIDUAL * spread:
                return S
            stays = np.flatnonzero(np.arange(len(off)) != off.argmax())
            there, here = [there[n] for n in stays], [here[n] for n in stays]
        return None


class SleepingMap:
    """A map that was lost, watching for keyframes of the present one."""

    def __init__(self, sparse: SparseMap) -> None:
        """Keep a map."""
        self.sparse = sparse
        self._landmarks = sparse.landmarks()
        self._recognitions = Recognitions(sparse.camera)

    def meet(self, present: SparseMap, keyframe: Keyframe) -> Similarity[World, World] | None:
        """Look for a keyframe here; return `S_here_present` once enough of them agree."""
        place = self._recognitions.recognise(self._landmarks, keyframe)
        if place is None:
            return None
        scales = {self.sparse.scale, present.scale}
        if scales == {Scale.METRIC, Scale.ARBITRARY}:
            return None  # the tags will put both into their world
        centre = place.T_cam_world.inverse().t
        away = np.linalg.norm(self._landmarks.points_world - centre, axis=1)
        return self._recognitions.agreed(present, depth=float(np.median(away)))
