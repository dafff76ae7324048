"""Points of the table that the head camera and a fixed camera above both see."""

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from gazemap.geometry.arrays import FloatArray, ImageArray
from gazemap.geometry.camera import Camera
from gazemap.ports import Session
from gazemap.scene.crops import PosedCamera
from gazemap.scene.rectified import RectifiedTable
from gazemap.types.tracking import Trajectory

_FEATURES: Final = 4000
_RATIO: Final = 0.8
_RANSAC_PX: Final = 3.0
_MIN_MATCHES: Final = 25
# Head frames are drawn so far apart; the later ones show parts that the earlier ones did not.
_PERIOD_S: Final = 0.5
# Images of the fixed camera that are tried: an arm or the light may spoil one.
_TRIES: Final = 3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TableMatches:
    """Points on the table as a fixed camera sees them.

    Attributes:
        points_world: (N, 3) on z = 0.
        uv_px: (N, 2) in the fixed camera's image.
    """

    points_world: FloatArray
    uv_px: FloatArray


def match_table(
    session: Session, trajectory: Trajectory, outline_xy: FloatArray
) -> TableMatches | None:
    """Return what the overhead camera sees of the table that head frames, drawn on it, show too.

    None where there is no such camera, or where too little agrees with one flat table: what stands
    on the table is drawn smeared, and falls out with what is matched wrongly.

    Args:
        session: the recording.
        trajectory: the head camera's path, in a world whose z = 0 is the table.
        outline_xy: (2, 2) opposite corners of the table.
    """
    if session.overhead_camera is None:
        return None
    table = RectifiedTable(outline_xy)
    drawn = _drawn_table(session, trajectory, table)
    if drawn is None:
        return None
    view = PosedCamera.of(table.camera, table.T_world_overhead, is_overhead=True)
    best: TableMatches | None = None
    for index, frame in enumerate(session.overhead_frames()):
        pairs = _consistent_pairs(frame.image, session.overhead_camera, drawn)
        if len(pairs) >= _MIN_MATCHES and (best is None or len(pairs) > len(best.uv_px)):
            xy = view.on_plane(pairs[:, 2:])
            best = TableMatches(
                points_world=np.column_stack([xy, np.zeros(len(xy))]), uv_px=pairs[:, :2]
            )
        if index + 1 == _TRIES:
            break
    return best


def _drawn_table(
    session: Session, trajectory: Trajectory, table: RectifiedTable
) -> ImageArray | None:
    drawn: ImageArray | None = None
    last_ns: int | None = None
    for frame in session.scene_frames():
        T_world_cam = trajectory.at(frame.t_ns)
        is_due = last_ns is None or frame.t_ns - last_ns >= _PERIOD_S * 1e9
        if T_world_cam is not None and is_due:
            last_ns = frame.t_ns
            drawn = table.draw(frame, session.scene_camera, T_world_cam).image
    return drawn


def _consistent_pairs(image: ImageArray, camera: Camera, drawn: ImageArray) -> FloatArray:
    """Return u, v in the image and u, v in the drawing (N, 4) that one homography relates."""
    sift = cv2.SIFT.create(nfeatures=_FEATURES)
    (of_image, words), (of_drawn, drawn_words) = (
        sift.detectAndCompute(_grey(each), None) for each in (image, drawn)
    )
    if min(len(of_image), len(of_drawn)) < 2:
        return np.zeros((0, 4))
    best = cv2.BFMatcher(cv2.NORM_L2).knnMatch(words, drawn_words, k=2)
    kept = [one for one, other in best if one.distance < _RATIO * other.distance]
    if len(kept) < _MIN_MATCHES:
        return np.zeros((0, 4))
    uv = np.array([of_image[m.queryIdx].pt for m in kept], dtype=np.float64)
    uv_drawn = np.array([of_drawn[m.trainIdx].pt for m in kept], dtype=np.float64)
    focal_px = float(camera.K[0, 0])
    flat_px = focal_px * camera.normalize(uv)
    _, inlier = cv2.findHomography(
        flat_px.astype(np.float32), uv_drawn.astype(np.float32), cv2.RANSAC, _RANSAC_PX
    )
    if inlier is None:
        return np.zeros((0, 4))
    return np.column_stack([uv, uv_drawn])[inlier.ravel() > 0]


def _grey(image: ImageArray) -> NDArray[np.uint8]:
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if image.ndim == 3 else image)
