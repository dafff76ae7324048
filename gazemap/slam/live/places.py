"""Recognising a place: binary descriptors of the reference patches, verified by geometry.

No vocabulary is needed: a map of a table has some thousand points, which brute force compares in
some ten milliseconds, and only while the track is lost.

Source:
    Rublee et al. 2011 (ORB): the orientation by the centroid of brightness, sec. 3.2, and BRIEF
    steered by it. The pairs here are drawn, not learnt.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from gazemap.geometry.arrays import FloatArray, ImageArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.compiled import compiled
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.live.landmarks import Landmarks
from gazemap.slam.live.patches import STORED_RADIUS, Pyramid, cut_patches
from gazemap.slam.live.refine import PoseProblem, refine_pose

_BITS = 256
_REACH = 12.0
_CENTRE = STORED_RADIUS + 0.5
_QUERY_CORNERS = 700
_WORST_DISTANCE = 64
_THRESHOLD_PX = 4.0
# Corners are found on even pixels and again: hardly better than a pixel.
_CORNER_SIGMA_PX = 1.2
_LEAST_INLIERS = 12
_LARGEST_INDEX = 6000


def _drawn_pairs() -> FloatArray:
    """Return pairs (256, 4) of offsets: two normal draws, cut at the patch's edge."""
    pairs = np.random.default_rng(31).normal(0.0, _REACH / 2.2, (_BITS, 4))
    return np.clip(pairs, -_REACH / np.sqrt(2), _REACH / np.sqrt(2))


_PAIRS = _drawn_pairs()


@compiled
def _direction(patch: ImageArray) -> tuple[float, float]:
    """Return the unit vector from the centre to the centroid of brightness."""
    x = 0.0
    y = 0.0
    for i in range(patch.shape[0]):
        for j in range(patch.shape[1]):
            dx, dy = j - STORED_RADIUS, i - STORED_RADIUS
            if dx * dx + dy * dy <= STORED_RADIUS * STORED_RADIUS:
                x += dx * patch[i, j]
                y += dy * patch[i, j]
    length = np.sqrt(x * x + y * y) + 1e-9
    return x / length, y / length


@compiled
def _describe(patches: ImageArray, pairs: FloatArray) -> ImageArray:
    out = np.zeros((len(patches), _BITS // 8), np.uint8)
    for n in range(len(patches)):
        c, s = _direction(patches[n])
        for k in range(_BITS):
            # Rounded by truncation: the centre's offset keeps the coordinates positive.
            x0, y0, x1, y1 = pairs[k]
            row, column = _CENTRE + s * x0 + c * y0, _CENTRE + c * x0 - s * y0
            a = patches[n, int(row), int(column)]
            row, column = _CENTRE + s * x1 + c * y1, _CENTRE + c * x1 - s * y1
            if a < patches[n, int(row), int(column)]:
                out[n, k // 8] |= np.uint8(1 << (k % 8))
    return out


def describe(references: ImageArray) -> ImageArray:
    """Return descriptors (N, 2, 32) of references (N, 2, S, S), one for each resolution."""
    count, levels, side, _ = references.shape
    # One tall image: the blur mixes neighbours in two rows at the edge, which no pair reaches.
    tall = np.ascontiguousarray(references).reshape(count * levels * side, side)
    if count == 0:
        return np.empty((0, levels, _BITS // 8), np.uint8)
    blurred = np.asarray(cv2.GaussianBlur(tall, (5, 5), 1.5), dtype=np.uint8)
    flat = _describe(blurred.reshape(count * levels, side, side), _PAIRS)
    return flat.reshape(count, levels, _BITS // 8)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Place:
    """Where a frame was recognised: the pose, and the points (N,) and pixels (N, 2) behind it."""

    T_cam_world: Pose[Cam, World]
    ids: IntArray
    uv_px: FloatArray


class PlaceIndex:
    """Descriptors of a map's points; those of known points are kept."""

    def __init__(self, camera: Camera) -> None:
        """Start empty."""
        self._camera = camera
        self._landmarks = Landmarks.none()
        self._descriptors: ImageArray = describe(self._landmarks.references)

    def take(self, landmarks: Landmarks) -> None:
        """Use a new state of the map, references included."""
        if landmarks is self._landmarks:
            return
        rows, known = self._landmarks.rows_of(landmarks.ids)
        descriptors = np.empty((len(landmarks), *self._descriptors.shape[1:]), np.uint8)
        descriptors[known] = self._descriptors[rows[known]]
        descriptors[~known] = describe(landmarks.references[~known])
        self._landmarks, self._descriptors = landmarks, descriptors

    def recognise(self, grey: ImageArray) -> Place | None:
        """Return where the image was taken; None where too few points agree."""
        query = query_of(grey)
        rows, uv_px = self._matches(query)
        if len(rows) < _LEAST_INLIERS:
            return None
        xy = self._camera.normalize(uv_px)
        solved = cv2.solvePnPRansac(
            self._landmarks.points_world[rows], xy, np.eye(3), None, iterationsCount=1000,
            reprojectionError=_THRESHOLD_PX / float(self._camera.K[0, 0]), confidence=0.999,
            flags=cv2.SOLVEPNP_AP3P,
        )  # fmt: skip
        inlier = np.ravel(solved[3] if solved[0] else []).astype(np.int64)
        if len(inlier) < _LEAST_INLIERS:
            return None
        start: Pose[Cam, World] = Pose.from_rotvec(np.ravel(solved[1]), np.ravel(solved[2]))
        T = self._refined(start, self._landmarks.points_world[rows[inlier]], xy[inlier])
        return Place(T_cam_world=T, ids=self._landmarks.ids[rows[inlier]], uv_px=uv_px[inlier])

    def _refined(
        self, start: Pose[Cam, World], points_world: FloatArray, xy: FloatArray
    ) -> Pose[Cam, World]:
        problem = PoseProblem(
            points_world=points_world,
            xy=xy,
            sigma=np.full(len(xy), _CORNER_SIGMA_PX / float(self._camera.K[0, 0])),
            dt_s=np.zeros(len(xy)),
            twist=np.zeros(6),
        )
        fit = refine_pose(start, problem)
        return fit.T_cam_world if fit is not None else start

    def _matches(self, query: "Query") -> tuple[IntArray, FloatArray]:
        """Return landmarks (M,) and pixels (M, 2) whose descriptors choose each other."""
        chosen = np.argsort(-self._landmarks.view_count, kind="stable")[:_LARGEST_INDEX]
        if len(chosen) == 0 or len(query.uv_px) == 0:
            return np.empty(0, np.int64), np.empty((0, 2))
        train = self._descriptors[chosen].reshape(-1, _BITS // 8)
        found = cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True).match(query.descriptors, train)
        near = [m for m in found if m.distance < _WORST_DISTANCE]
        rows = chosen[np.array([m.trainIdx // 2 for m in near], dtype=np.int64)]
        which = np.array([m.queryIdx // 2 for m in near], dtype=np.int64)
        return rows, query.uv_px[which]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Query:
    """An image's corners (N, 2) and their descriptors (2 N, 32), both resolutions of each."""

    uv_px: FloatArray
    descriptors: ImageArray


def query_of(grey: ImageArray) -> Query:
    """Describe an image."""
    corners = cv2.goodFeaturesToTrack(grey, _QUERY_CORNERS, 0.003, 6)
    # OpenCV gives None, not an empty array, where it finds nothing.
    found = np.asarray(corners, dtype=np.float64)
    found = found.reshape(-1, 2) if found.ndim == 3 else np.empty((0, 2))
    uv_px = 2.0 * np.rint(found / 2.0)
    height, width = grey.shape
    inside = np.asarray((uv_px[:, 0] < width - 2) & (uv_px[:, 1] < height - 2))
    uv_px = uv_px[inside]
    descriptors = describe(cut_patches(Pyramid.of(grey), uv_px))
    return Query(uv_px=uv_px, descriptors=descriptors.reshape(-1, _BITS // 8))
