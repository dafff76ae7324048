"""What stands out of the table in one image from above."""

from dataclasses import dataclass

import cv2
import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray, IntArray
from gazemap.scene.config import ForegroundConfig
from gazemap.scene.crops import PosedCamera, as_bgr

_FIRST_TRIMS = 6
_LATER_TRIMS = 2
_SAMPLE_COUNT = 4000
_MIN_SIGMA = np.array([4.0, 2.0, 2.5])  # of L, a, b as 8-bit numbers


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Region:
    """A connected patch that is not table.

    Attributes:
        pixels: (N,) flat indices of its pixels in the reduced image.
        centroid_px: (2,) in the reduced image.
    """

    pixels: IntArray
    centroid_px: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rectangle:
    """A rectangle on the table.

    Attributes:
        centre_xy: (2,) metres.
        sides_m: (2,) the first along yaw_rad.
        yaw_rad: heading about z.
    """

    centre_xy: FloatArray
    sides_m: FloatArray
    yaw_rad: float


class TableView:
    """The table in a fixed view, at reduced resolution."""

    def __init__(self, view: PosedCamera, outline_xy: FloatArray, config: ForegroundConfig) -> None:
        """Find out which pixels show the table whose outline (N, 2) is given in world."""
        self._config = config
        k = config.reduction
        self.shape = (view.camera.height_px // k, view.camera.width_px // k)
        v, u = np.mgrid[0 : self.shape[0], 0 : self.shape[1]]
        full_px = (np.stack([u, v], -1).reshape(-1, 2) + 0.5) * k - 0.5
        self.xy = view.on_plane(full_px)  # (h * w, 2)
        low, high = outline_xy.min(axis=0), outline_xy.max(axis=0)
        inside = ((self.xy > low) & (self.xy < high)).all(axis=1)
        self._is_table = inside.reshape(self.shape)
        step = np.linalg.norm(np.diff(self.xy.reshape(*self.shape, 2), axis=1), axis=2)
        self.pixel_m = float(np.median(step[self._is_table[:, 1:]]))
        self._rim = self._is_table & ~_eroded(self._is_table)
        self._centre, self._root = np.zeros(3), np.eye(3)
        self._first_level = 0.0
        self._is_first = True

    def reduce(self, image: ImageArray) -> ImageArray:
        """Return the image at the resolution that is segmented (h, w, 3), in CIELAB."""
        size = (self.shape[1], self.shape[0])
        small = cv2.resize(as_bgr(image), size, interpolation=cv2.INTER_AREA)
        return np.asarray(cv2.cvtColor(small, cv2.COLOR_BGR2LAB), dtype=np.uint8)

    def stands_out(self, lab: ImageArray) -> BoolArray:
        """Return which pixels (h, w) have a colour that the table does not have.

        The table's colours are the bulk of what lies inside its outline: a Gaussian, trimmed
        until what is left belongs to it. It follows the light from frame to frame.
        """
        self._learn(lab)
        root = self._root.T.astype(np.float32)
        offset = -root @ self._centre.astype(np.float32)
        scaled = cv2.transform(lab.astype(np.float32), np.column_stack([root, offset]))
        far = np.einsum("ijk,ijk->ij", scaled, scaled) > self._config.min_distance_sigma**2
        return np.asarray(far & self._is_table)

    def levelled(self, lab: ImageArray) -> ImageArray:
        """Return an image in the light of the first frame, by how bright the table is now."""
        gain = self._first_level / max(float(self._centre[0]), 1.0)
        lightness = np.clip(lab[..., :1] * gain, 0, 255).astype(np.uint8)
        return np.concatenate([lightness, lab[..., 1:]], axis=2)

    def _learn(self, lab: ImageArray) -> None:
        pixels = lab[self._is_table]
        sample = pixels[:: max(1, len(pixels) // _SAMPLE_COUNT)].astype(np.float64)
        if self._is_first:
            self._centre = np.median(sample, axis=0)
            spread = 1.4826 * np.median(np.abs(sample - self._centre), axis=0)
            self._root = np.diag(1 / np.hypot(spread, _MIN_SIGMA))
        for _ in range(_FIRST_TRIMS if self._is_first else _LATER_TRIMS):
            scaled = (sample - self._centre) @ self._root
            bulk = sample[(scaled**2).sum(axis=1) < self._config.min_distance_sigma**2]
            self._centre = bulk.mean(axis=0)
            values, vectors = np.linalg.eigh(np.cov(bulk.T) + np.diag(_MIN_SIGMA**2))
            self._root = vectors / np.sqrt(values)
        if self._is_first:
            self._first_level = float(self._centre[0])
        self._is_first = False

    def regions(self, is_foreground: BoolArray) -> list[Region]:
        """Return the connected patches of an object's size that do not reach the table's edge."""
        opened = cv2.morphologyEx(
            is_foreground.astype(np.uint8), cv2.MORPH_OPEN, np.ones((2, 2), np.uint8)
        )
        _, labels, stats, centroids = cv2.connectedComponentsWithStats(opened, connectivity=4)
        sides = stats[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].max(axis=1) * self.pixel_m
        area = stats[:, cv2.CC_STAT_AREA] * self.pixel_m**2
        fits = (area >= self._config.min_area_m2) & (sides < self._config.max_length_m)
        fits[0] = False
        fits[np.unique(labels[self._rim])] = False
        return [
            Region(pixels=np.flatnonzero(labels == k), centroid_px=centroids[k])
            for k in np.flatnonzero(fits)
        ]

    def rectangle(self, pixels: IntArray) -> Rectangle:
        """Return the smallest rectangle on the table around pixels (N,), as if they lay on it."""
        corners = cv2.boxPoints(cv2.minAreaRect(self.xy[pixels].astype(np.float32)))
        along = corners[1] - corners[0]
        return Rectangle(
            centre_xy=corners.mean(axis=0).astype(np.float64),
            sides_m=np.linalg.norm(np.diff(corners[:3], axis=0), axis=1).astype(np.float64),
            yaw_rad=float(np.arctan2(along[1], along[0])),
        )


def _eroded(mask: BoolArray) -> BoolArray:
    inner = cv2.erode(mask.astype(np.uint8), np.ones((5, 5), np.uint8))
    inner[[0, 1, -2, -1], :] = 0
    inner[:, [0, 1, -2, -1]] = 0
    return np.asarray(inner > 0)
