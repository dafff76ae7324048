"""Two maps of the same place: when they meet, and by what similarity."""

import numpy as np

from gazemap.geometry.align import Similarity, fit_similarity_of_poses
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.live.mapdata import Keyframe, SparseMap
from gazemap.slam.live.places import PlaceIndex
from gazemap.types.tracking import Scale

_LEAST_KEYFRAMES = 3
# A map drifts: what was recognised long ago agrees less.
_LATEST_KEYFRAMES = 5
_LEAST_INLIERS = 30
# The baseline of the keyframes over the depth, below which their scale says nothing.
_LEAST_BASELINE = 0.05
_WORST_RESIDUAL = 0.12


class SleepingMap:
    """A map that was lost, watching for keyframes of the present one."""

    def __init__(self, sparse: SparseMap) -> None:
        """Index the places of a map."""
        self.sparse = sparse
        self._index = PlaceIndex(sparse.camera)
        self._landmarks = sparse.landmarks()
        self._index.take(self._landmarks)
        self._recognised: dict[int, Pose[World, Cam]] = {}

    def meet(self, present: SparseMap, keyframe: Keyframe) -> Similarity[World, World] | None:
        """Look for a keyframe here; return `S_here_present` once enough of them agree."""
        if keyframe.pyramid is None:
            return None
        place = self._index.recognise(keyframe.pyramid.full)
        if place is None or len(place.ids) < _LEAST_INLIERS:
            return None
        self._recognised[keyframe.keyframe_id] = place.T_cam_world.inverse()
        ids = [k for k in self._recognised if k in present.keyframes][-_LATEST_KEYFRAMES:]
        there = [present.keyframes[k].T_cam_world.inverse() for k in ids]
        here = [self._recognised[k] for k in ids]
        if Scale.METRIC in (self.sparse.scale, present.scale) and (
            self.sparse.scale is not present.scale
        ):
            return None  # the tags will put both into their world
        return self._agreed(there, here)

    def _agreed(
        self, there: list[Pose[World, Cam]], here: list[Pose[World, Cam]]
    ) -> Similarity[World, World] | None:
        """Return the similarity that most of the pairs agree on; the worst ones are left out."""
        points = self._landmarks.points_world
        while len(here) >= _LEAST_KEYFRAMES:
            centres = np.array([T.t for T in here])
            spread = float(np.linalg.norm(centres - centres.mean(axis=0), axis=1).max())
            depth = float(np.median(np.linalg.norm(points - centres[-1], axis=1)))
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
