"""How the image moved where the head has no pose, from optic flow.

Without a pose gaze cannot be carried into the world, but a fixation can still be told: the eye
that holds a point moves against the image as that point's image moves. What is looked at lies on
or near one plane, so corners followed from frame to frame give the homography that moves most of
the image, head's translation included. Homographies are chained over each stretch without poses.

Source:
    Lucas and Kanade 1981 in pyramids, after Bouguet 2001; homographies of a plane after Hartley
    and Zisserman 2004, section 13.1, robust by RANSAC.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, GazeCam, Pose
from gazemap.types.frame import Frame

_WIDTH_PX: Final = 480
_CORNERS: Final = 200
_MIN_CORNERS: Final = 12
_NEAR: Final = 0.002  # of the focal length, from where the homography puts a corner
_MIN_SHARE: Final = 0.4  # of the corners that one homography explains
_MARGIN_NS: Final = 1_000_000_000  # a fixation may begin before the pose is lost
_MAX_GAP_NS: Final = 150_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ImageMotion:
    """Where what is seen at each frame lay in the first image of its stretch.

    Attributes:
        t_ns: (N,) of the frames, increasing.
        H_reference_cam: (N, 3, 3) map rays of each frame's camera to rays of the first of its
            stretch, up to scale.
        reference: (N,) the number of the stretch.
    """

    t_ns: IntArray
    H_reference_cam: FloatArray
    reference: IntArray

    def carrying(self, T_cam_other: Pose[Cam, GazeCam]) -> "ImageMotion":
        """Return the motion in another camera that is fixed beside this one, with as far a view."""
        return replace(self, H_reference_cam=T_cam_other.R.T @ self.H_reference_cam @ T_cam_other.R)

    def at(self, t_ns: IntArray) -> tuple[FloatArray, IntArray]:
        """Return `H_reference_cam` (M, 3, 3) at times, and the reference (M,), -1 for none."""
        after = np.clip(np.searchsorted(self.t_ns, t_ns), 1, len(self.t_ns) - 1)
        gap_ns = self.t_ns[after] - self.t_ns[after - 1]
        share = ((t_ns - self.t_ns[after - 1]) / gap_ns)[:, None, None]
        H = (1 - share) * self.H_reference_cam[after - 1] + share * self.H_reference_cam[after]
        is_near = (t_ns >= self.t_ns[0]) & (t_ns <= self.t_ns[-1]) & (gap_ns <= _MAX_GAP_NS)
        is_one = self.reference[after] == self.reference[after - 1]
        return H, np.where(is_near & is_one, self.reference[after], -1)


def image_motion(
    frames: Iterator[Frame], t_ns: IntArray, camera: Camera, *, is_posed: BoolArray
) -> ImageMotion | None:
    """Return how the image moved where frames have no pose, or None where that is not known.

    Args:
        frames: of the head camera; not touched unless poses are missing.
        t_ns: (N,) the times of all frames.
        camera: the head camera.
        is_posed: (N,) which frames have a pose.
    """
    if is_posed.all():
        return None
    steps = _steps(frames, camera, _is_wanted(t_ns, is_posed))
    cuts = [0, *(i for i in range(1, len(t_ns)) if steps[i] is None), len(t_ns)]
    stretches = [range(a, b) for a, b in pairwise(cuts) if b - a > 1]
    if not stretches:
        return None
    return ImageMotion(
        t_ns=np.concatenate([t_ns[s.start : s.stop] for s in stretches]),
        H_reference_cam=np.concatenate([_chained(steps[s.start + 1 : s.stop]) for s in stretches]),
        reference=np.concatenate([np.full(len(s), number) for number, s in enumerate(stretches)]),
    )


def _is_wanted(t_ns: IntArray, is_posed: BoolArray) -> BoolArray:
    """Return which frames (N,) have no pose, or are shortly before or after one without."""
    lost_ns = t_ns[~is_posed]
    first = np.searchsorted(lost_ns, t_ns - _MARGIN_NS)
    return np.asarray(first < np.searchsorted(lost_ns, t_ns + _MARGIN_NS, side="right"))


def _steps(
    frames: Iterator[Frame], camera: Camera, is_wanted: BoolArray
) -> list[FloatArray | None]:
    """Return `H_before_cam` of each frame, None where it is not wanted or not known."""
    steps: list[FloatArray | None] = [None] * len(is_wanted)
    before: ImageArray | None = None
    for i, frame in zip(range(len(is_wanted)), frames, strict=False):
        now = _small_grey(frame.image) if is_wanted[i] else None
        if before is not None and now is not None:
            steps[i] = plane_motion(before, now, camera)
        before = now
    return steps


def _chained(steps: list[FloatArray | None]) -> FloatArray:
    """Return `H_first_cam` (N + 1, 3, 3) of a stretch of N steps."""
    chained = [np.eye(3)]
    for step in steps:
        chained.append(chained[-1] if step is None else _scaled(chained[-1] @ step))
    return np.array(chained)


def plane_motion(before: ImageArray, after: ImageArray, camera: Camera) -> FloatArray | None:
    """Return `H_before_after` (3, 3) that explains how most corners moved, or None if none does.

    Args:
        before: (h, w) grey, the camera's image or a smaller copy of it.
        after: (h, w) the next one.
        camera: at its own resolution.
    """
    corners = _corners(before)
    if len(corners) < _MIN_CORNERS:
        return None
    moved, status, _ = cv2.calcOpticalFlowPyrLK(
        before, after, corners, np.empty_like(corners), winSize=(15, 15), maxLevel=3
    )
    is_found = status.ravel() > 0
    if np.count_nonzero(is_found) < _MIN_CORNERS:
        return None
    shrink = camera.width_px / before.shape[1]
    flat_before, flat_after = (
        camera.normalize((points[is_found, 0].astype(np.float64) + 0.5) * shrink - 0.5)
        for points in (corners, moved)
    )
    found: tuple[object, object] = cv2.findHomography(flat_after, flat_before, cv2.RANSAC, _NEAR)
    if found[0] is None or np.mean(np.asarray(found[1])) < _MIN_SHARE:
        return None
    return _scaled(np.asarray(found[0], np.float64))


def _scaled(H: FloatArray) -> FloatArray:
    scaled: FloatArray = H / np.cbrt(np.linalg.det(H))
    return scaled


def _corners(grey: ImageArray) -> NDArray[np.float32]:
    """Return corners (N, 1, 2) of an image; none in a blank one."""
    found: object = cv2.goodFeaturesToTrack(grey, _CORNERS, 0.01, grey.shape[1] / 40)
    return np.empty((0, 1, 2), np.float32) if found is None else np.asarray(found, np.float32)


def _small_grey(image: ImageArray) -> ImageArray:
    grey = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    height, width = grey.shape
    if width <= _WIDTH_PX:
        return np.asarray(grey, np.uint8)
    size_px = (_WIDTH_PX, round(height * _WIDTH_PX / width))
    return np.asarray(cv2.resize(grey, size_px, interpolation=cv2.INTER_AREA), np.uint8)
