"""What moves by itself in view, hands and carried things, as a coarse mask of each frame.

Two cues. Motion against the map: a corner that a frame shows elsewhere than any depth explains
votes against its surroundings, corners that the map explains vote for them. Skin: places of its
chroma that reach in from the image's border, as an arm does. Wood and brick have that chroma too,
so colours are learnt from the votes, and a place that moves with the map is no hand.

Corners in the mask are still followed: that they move is how the mask is known. What the mask
covers is not measured, so nothing in it becomes a point of the map.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose

_COLUMNS = 48
_FEWEST_KNOWN = 8
# Depths that a corner may have whose depth is not known, over the usual one.
_NEAREST, _FARTHEST = 0.4, 50.0
_MOVING_PX = 1.5
_MOVING_SCATTERS = 5.0
_STATIC_PX = 0.7
# Votes count for some frames, over the cells around.
_VOTE_DECAY = 0.7
_VOTE_CELLS = 5
_LEAST_VOTES = 3.5
_LEAST_SKIN_VOTES = 1.0
_RIM_CELLS = 3
_SKIN_CR, _SKIN_CB = (135, 173), (80, 127)
_COLOUR_BITS = 3
_COLOUR_DECAY = 0.98
_SKIN_PRIOR = 8.0
_LEARNT_COLOURS = 500.0
_SMALLEST_SKIN = 0.004
# A skin-coloured place this full of what the map explains, over the whole image, is no hand.
_FULL_OF_STATIC = 0.3
# A mask of more is a mistake: a hand leaves more to see.
_LARGEST = 0.45

FloatGrid = NDArray[np.float32]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Followed:
    """Corners of one frame found again in the next.

    Attributes:
        before_px: (N, 2) in the frame before.
        after_px: (N, 2) in this one.
        depth: (N,) in the frame before; NaN where it is not known.
    """

    before_px: FloatArray
    after_px: FloatArray
    depth: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Votes:
    """Pixels of this frame that moved with the map (N, 2), and that did not (M, 2)."""

    static_px: FloatArray
    moving_px: FloatArray


NO_VOTES = Votes(static_px=np.empty((0, 2)), moving_px=np.empty((0, 2)))


def votes_of(followed: Followed, camera: Camera, *, T_after_before: Pose[Cam, Cam]) -> Votes:
    """Return how corners moved, judged by how the camera did.

    A corner of unknown depth is judged by the nearest place that some depth would explain.

    Args:
        followed: the corners; without some of known depth there are no votes.
        camera: the head camera.
        T_after_before: from the camera in the frame before to that in this one.
    """
    known = np.isfinite(followed.depth)
    if known.sum() < _FEWEST_KNOWN:
        return NO_VOTES
    usual = float(np.median(followed.depth[known]))
    near = np.where(known, followed.depth, _NEAREST * usual)
    far = np.where(known, followed.depth, _FARTHEST * usual)
    flat = camera.normalize(followed.before_px)
    ray = np.column_stack([flat, np.ones(len(flat))])
    at_near = camera.project(T_after_before.transform(ray * near[:, None]))
    at_far = camera.project(T_after_before.transform(ray * far[:, None]))
    off_px = np.nan_to_num(_distance_from_segments(followed.after_px, at_near, at_far))
    limit_px = max(_MOVING_PX, _MOVING_SCATTERS * float(np.median(off_px[known])))
    return Votes(
        static_px=followed.after_px[off_px < max(_STATIC_PX, 0.5 * limit_px)],
        moving_px=followed.after_px[off_px > limit_px],
    )


def _distance_from_segments(at: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    along = end - start
    length = (along**2).sum(axis=1)
    part = ((at - start) * along).sum(axis=1) / np.maximum(length, 1e-12)
    nearest = start + np.clip(part, 0.0, 1.0)[:, None] * along
    return np.asarray(np.linalg.norm(at - nearest, axis=1))


@dataclass(frozen=True, slots=True, kw_only=True)
class MaskGrid:
    """The square cells of a mask: their side, and how many rows and columns there are."""

    cell_px: float
    shape: tuple[int, int]

    @staticmethod
    def over(*, width_px: int, height_px: int) -> "MaskGrid":
        """Return the cells of an image."""
        rows = max(1, round(height_px * _COLUMNS / width_px))
        return MaskGrid(cell_px=width_px / _COLUMNS, shape=(rows, _COLUMNS))

    def cells(self, uv_px: FloatArray) -> tuple[IntArray, IntArray]:
        """Return the row and the column of the cells that pixels (N, 2) lie in."""
        column, row = ((uv_px + 0.5) / self.cell_px).astype(np.int64).T
        return np.clip(row, 0, self.shape[0] - 1), np.clip(column, 0, self.shape[1] - 1)


class MovingMask:
    """The mask of the latest frame, and what frames before taught about places and colours."""

    def __init__(self, *, width_px: int, height_px: int) -> None:
        """Start with an empty mask for images of a size."""
        self.grid = MaskGrid.over(width_px=width_px, height_px=height_px)
        bins = 256 >> _COLOUR_BITS
        self._static_colours = np.zeros((bins, bins))
        self._moving_colours = np.zeros((bins, bins))
        self.forget()

    def forget(self) -> None:
        """Empty the mask: the frame before is no longer the one before."""
        self._static: FloatGrid = np.zeros(self.grid.shape, np.float32)
        self._moving: FloatGrid = np.zeros(self.grid.shape, np.float32)
        self.is_moving: BoolArray = np.zeros(self.grid.shape, np.bool_)

    def update(self, votes: Votes, chroma: ImageArray | None) -> None:
        """Take the votes of a frame, and its colours unless it is grey.

        Args:
            votes: of corners in this frame.
            chroma: as `coarse_chroma` gives it, or None.
        """
        static, moving = self._counts(votes.static_px), self._counts(votes.moving_px)
        self._static = _VOTE_DECAY * self._static + static
        self._moving = _VOTE_DECAY * self._moving + moving
        size = (_VOTE_CELLS, _VOTE_CELLS)
        against, agreeing = (
            np.asarray(cv2.boxFilter(votes, -1, size, normalize=False), dtype=np.float32)
            for votes in (self._moving, self._static)
        )
        mask = ((against >= _LEAST_VOTES) & (against > agreeing)).astype(np.uint8)
        if chroma is not None:
            colour = _colour_of(chroma)
            self._learn(colour, static, moving)
            mask |= self._skin(chroma, colour, against)
        grown = cv2.dilate(mask, np.ones((_RIM_CELLS, _RIM_CELLS), np.uint8))
        is_believed = grown.mean() <= _LARGEST
        self.is_moving = (grown > 0) & is_believed

    def covers(self, uv_px: FloatArray) -> BoolArray:
        """Return which pixels (N, 2) the mask covers."""
        covered: BoolArray = self.is_moving[self.grid.cells(uv_px)]
        return covered

    def _counts(self, uv_px: FloatArray) -> FloatGrid:
        counts = np.zeros(self.grid.shape, np.float32)
        np.add.at(counts, self.grid.cells(uv_px), np.float32(1))
        return counts

    def _learn(self, colour: IntArray, static: FloatGrid, moving: FloatGrid) -> None:
        for colours, counts in ((self._static_colours, static), (self._moving_colours, moving)):
            fresh = np.bincount(colour.ravel(), counts.ravel(), minlength=colours.size)
            np.multiply(colours, _COLOUR_DECAY, out=colours)
            np.add(colours, fresh.reshape(colours.shape), out=colours)

    def _skin(self, chroma: ImageArray, colour: IntArray, against: FloatGrid) -> ImageArray:
        """Return the places (h, w) of skin that reach in from the border and do not rest."""
        nothing = np.zeros(self.grid.shape, np.uint8)
        if self._static_colours.sum() < _LEARNT_COLOURS:
            return nothing
        is_usual = cv2.blur(self._static_colours, (3, 3)) > (
            _SKIN_PRIOR + cv2.blur(self._moving_colours, (3, 3))
        )
        is_skin = cv2.inRange(chroma, (_SKIN_CR[0], _SKIN_CB[0]), (_SKIN_CR[1], _SKIN_CB[1]))
        is_skin[is_usual.ravel()[colour]] = 0
        count, labels = cv2.connectedComponents(is_skin, connectivity=4)
        area = np.bincount(labels.ravel(), minlength=count)
        static = np.bincount(labels.ravel(), self._static.ravel(), minlength=count)
        is_hand = area >= _SMALLEST_SKIN * labels.size
        is_hand &= np.bincount(labels[against >= _LEAST_SKIN_VOTES], minlength=count) > 0
        is_hand &= static < _FULL_OF_STATIC * float(self._static.mean()) * area
        border = np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]])
        is_hand &= np.bincount(border, minlength=count) > 0
        is_hand[0] = False
        return np.asarray(is_hand[labels], dtype=np.uint8)


def _colour_of(chroma: ImageArray) -> IntArray:
    """Return which bin of the colours' histogram each cell (h, w) falls into."""
    bins = (chroma >> _COLOUR_BITS).astype(np.int64)
    colour: IntArray = bins[..., 0] * (256 >> _COLOUR_BITS) + bins[..., 1]
    return colour


def coarse_chroma(image: ImageArray) -> ImageArray | None:
    """Return Cr and Cb (h, w, 2) of an image at the mask's resolution; None for a grey one.

    Args:
        image: (height, width) or BGR (height, width, 3).
    """
    shape: tuple[int, ...] = image.shape
    if len(shape) == 2:
        return None
    rows, columns = MaskGrid.over(width_px=shape[1], height_px=shape[0]).shape
    step = max(1, shape[1] // (2 * columns))
    thinned = np.ascontiguousarray(image[::step, ::step])
    small = cv2.resize(thinned, (columns, rows), interpolation=cv2.INTER_AREA)
    return np.ascontiguousarray(cv2.cvtColor(small, cv2.COLOR_BGR2YCrCb)[..., 1:])
