"""AprilTags: corners to a tenth of a pixel from the edges of the black square."""

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from gazemap.errors import InputError
from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray
from gazemap.geometry.camera import Camera
from gazemap.slam.grey import to_grey

_DICTIONARIES: Final = {
    "tag16h5": cv2.aruco.DICT_APRILTAG_16h5,
    "tag25h9": cv2.aruco.DICT_APRILTAG_25h9,
    "tag36h10": cv2.aruco.DICT_APRILTAG_36h10,
    "tag36h11": cv2.aruco.DICT_APRILTAG_36h11,
}
_MODULES: Final = {"tag16h5": 6, "tag25h9": 7, "tag36h10": 8, "tag36h11": 8}

_SAMPLES_PER_EDGE: Final = 24
_STEPS_PER_PIXEL: Final = 4
_SMALLEST_SIDE_PX: Final = 12.0
_WEAKEST_EDGE_GREY: Final = 12.0
_LARGEST_SHIFT_PX: Final = 2.5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TagView:
    """One tag in one image.

    Attributes:
        tag_id: its number in the family.
        corners_px: (4, 2) on the distorted image: top-left, top-right, bottom-right, bottom-left
            as printed.
        corners_norm: (4, 2) the same as x/z, y/z.
    """

    tag_id: int
    corners_px: FloatArray
    corners_norm: FloatArray


class TagDetector:
    """Finds the tags of one family in the images of one camera."""

    def __init__(self, *, family: str, camera: Camera) -> None:
        """Prepare the detector.

        Args:
            family: `tag36h11` or another AprilTag family that OpenCV knows.
            camera: the camera that took the images.

        Raises:
            InputError: if the family is not known.
        """
        if family not in _DICTIONARIES:
            known = ", ".join(sorted(_DICTIONARIES))
            raise InputError(
                f"tag family {family!r} is not known", where="tags.yaml", todo=f"use one of {known}"
            )
        parameters = cv2.aruco.DetectorParameters()
        # The sub-pixel methods of OpenCV are biased or noisier than the line fit below.
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_NONE
        dictionary = cv2.aruco.getPredefinedDictionary(_DICTIONARIES[family])
        self._detector = cv2.aruco.ArucoDetector(dictionary, parameters)
        self._camera = camera
        self._modules = _MODULES[family]

    def detect(self, image: ImageArray) -> tuple[TagView, ...]:
        """Return the tags whose four edges are sharp enough to measure, by ascending id.

        Args:
            image: (height, width) grey or (height, width, 3) BGR.
        """
        grey = to_grey(image)
        corners, ids, _ = self._detector.detectMarkers(grey)
        views = []
        # OpenCV gives None, not an empty array, where it finds nothing.
        found = np.asarray(ids if corners else [], dtype=np.int64).ravel().tolist()
        for tag_id, quad in zip(found, corners, strict=True):
            view = self._measured(grey, tag_id, np.asarray(quad, dtype=np.float64)[0])
            if view is not None:
                views.append(view)
        return tuple(sorted(views, key=lambda view: view.tag_id))

    def _measured(self, grey: ImageArray, tag_id: int, quad_px: FloatArray) -> TagView | None:
        side_px = float(np.linalg.norm(np.roll(quad_px, -1, axis=0) - quad_px, axis=1).min())
        if side_px < _SMALLEST_SIDE_PX:
            return None
        # The window ends before the next edge, one module away.
        reach_px = float(np.clip(0.8 * side_px / self._modules, 1.5, 4.0))
        refined = quad_px
        for _ in range(2):
            sharper = self._intersected(grey, quad_px=refined, reach_px=reach_px)
            if sharper is None:
                return None
            refined = sharper
        if float(np.abs(refined - quad_px).max()) > _LARGEST_SHIFT_PX:
            return None
        corners_norm = self._camera.normalize(refined)
        return TagView(tag_id=tag_id, corners_px=refined, corners_norm=corners_norm)

    def _intersected(
        self, grey: ImageArray, *, quad_px: FloatArray, reach_px: float
    ) -> FloatArray | None:
        """Return the corners (4, 2) at which the lines along the four edges meet, in pixels."""
        edge_px, is_sharp = edge_points(grey, quad_px, reach_px=reach_px)
        lines = []
        for points_px, sharp in zip(edge_px, is_sharp, strict=True):
            if sharp.sum() < _SAMPLES_PER_EDGE // 2:
                return None
            # Edges are straight only where the lens no longer bends them.
            lines.append(fit_line(self._camera.normalize(points_px[sharp])))
        corners = [np.cross(lines[k - 1], lines[k]) for k in range(4)]
        flat = np.array([c[:2] / c[2] if abs(c[2]) > 1e-12 else [np.nan, np.nan] for c in corners])
        if not np.isfinite(flat).all():
            return None
        corners_px = self._camera.project(np.column_stack([flat, np.ones(4)]))
        return corners_px if np.isfinite(corners_px).all() else None


def edge_points(
    grey: ImageArray, quad_px: FloatArray, *, reach_px: float
) -> tuple[FloatArray, BoolArray]:
    """Return points (4, S, 2) on the edges of a dark quadrilateral, and which are sharp (4, S).

    Across each edge the brightness rises outwards; the edge is the centroid of that rise, which
    symmetric blur does not move.

    Args:
        grey: (height, width).
        quad_px: (4, 2) corners within a pixel or two, clockwise in the image.
        reach_px: half the length of the profiles across the edge.
    """
    along = np.linspace(0.12, 0.88, _SAMPLES_PER_EDGE)[None, :, None]
    start, end = quad_px[:, None], np.roll(quad_px, -1, axis=0)[:, None]
    direction = (end - start) / np.linalg.norm(end - start, axis=2, keepdims=True)
    # Clockwise with y down: outwards is to the left of the direction of travel.
    outward = np.stack([direction[..., 1], -direction[..., 0]], axis=-1)  # (4, 1, 2)
    centre = start + along * (end - start)  # (4, S, 2)
    step_count = int(2 * reach_px * _STEPS_PER_PIXEL) + 1
    offset = np.linspace(-reach_px, reach_px, step_count)
    at = (centre[:, :, None] + offset[:, None] * outward[:, :, None]).astype(np.float32)
    flat = at.reshape(4 * _SAMPLES_PER_EDGE, step_count, 2)
    profile = cv2.remap(
        grey.astype(np.float32), flat[..., 0], flat[..., 1], cv2.INTER_LINEAR, None,
        cv2.BORDER_REPLICATE,
    ).reshape(4, _SAMPLES_PER_EDGE, step_count)  # fmt: skip
    rise = np.clip(np.diff(profile.astype(np.float64), axis=2), 0.0, None)
    total = rise.sum(axis=2)
    middle = 0.5 * (offset[1:] + offset[:-1])
    shift = (rise * middle).sum(axis=2) / np.maximum(total, 1e-9)
    return centre + shift[..., None] * outward, total > _WEAKEST_EDGE_GREY


def fit_line(points: FloatArray) -> FloatArray:
    """Return the homogeneous line (3,) of points (N, 2), with points off it weighted down."""
    weight = np.ones(len(points))
    line = np.zeros(3)
    for _ in range(4):
        mean = weight @ points / weight.sum()
        centred = points - mean
        normal = np.linalg.svd((centred * weight[:, None]).T @ centred)[0][:, 1]
        distance = np.abs(centred @ normal)
        weight = 1.0 / (1.0 + (distance / max(float(np.median(distance)) * 2.0, 1e-9)) ** 2)
        line = np.array([normal[0], normal[1], -float(normal @ mean)])
    return line
