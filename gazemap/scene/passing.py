"""When a thing came to its place and when it left: looked up once it is certain that it did.

A hand hides a place for a second or two before the thing is lifted, and while it is set down; an
arm may have the table's colours or the thing's. But each pixel of the place looks one way with
the thing there and another way without it, and both are known afterwards: only pixels that look
as they will without the thing tell that it is gone.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray, IntArray

SAME_COLOUR = 30.0  # distance in 8-bit CIELAB below which a pixel looks as it did
_SAME_TABLE = 9.0  # the same for the table: closer, for an arm may be of nearly its colour
_HIDDEN_NS = 500_000_000  # a hand that hides a thing at rest takes it, or lets it go, so soon
_WITH_SHARE = 0.25  # of the telling pixels: the thing is there
_WITHOUT_SHARE = 0.15  # of the telling pixels: it is not
_MIN_TELLING = 12
_BEFORE_FRAMES = 5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SeenFrame:
    """One segmented frame of the fixed camera.

    Attributes:
        t_ns: its time.
        lab: (h, w, 3) CIELAB, levelled to the light of the first frame.
        stands_out: (h, w) which pixels do not look like the table.
    """

    t_ns: int
    lab: ImageArray
    stands_out: BoolArray

    def at(self, pixels: IntArray) -> FloatArray:
        """Return the colours (N, 3) of pixels given by flat indices (N,)."""
        return np.asarray(self.lab.reshape(-1, 3)[pixels], dtype=np.float64)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Evidence:
    """What the frames (F,) say about one place: shares of its telling pixels."""

    t_ns: list[int]
    is_there: BoolArray
    is_gone: BoolArray


def leaving_ns(
    pixels: IntArray, colours_with: FloatArray, history: Sequence[SeenFrame]
) -> int | None:
    """Return when a thing left that is not there in the latest frame.

    Between the last frame that shows it and the first that shows its place without it, a hand
    hides both; it left about half-way between, and soon.

    Args:
        pixels: (N,) flat indices of its pixels.
        colours_with: (N, 3) how they look with it.
        history: the latest frames in time order.

    Returns:
        The time; None where the place looks the same with and without it.
    """
    evidence = _weigh(pixels, colours_with, history[-1].at(pixels), history)
    if evidence is None:
        return None
    seen = np.flatnonzero(evidence.is_there)
    last = int(seen[-1]) if len(seen) else 0
    gone = np.flatnonzero(evidence.is_gone[last:])
    first_gone = last + int(gone[0]) if len(gone) else len(history) - 1
    last_ns, gone_ns = evidence.t_ns[last], evidence.t_ns[first_gone]
    return min((last_ns + gone_ns) // 2, last_ns + _HIDDEN_NS)


def arrival_ns(
    pixels: IntArray, colours_with: FloatArray, history: Sequence[SeenFrame]
) -> int | None:
    """Return when a thing came that is there in the latest frame; arguments as for leaving.

    None where the oldest frames show it there already.
    """
    before = np.median([seen.at(pixels) for seen in list(history)[:_BEFORE_FRAMES]], axis=0)
    evidence = _weigh(pixels, colours_with, before, history)
    if evidence is None or not evidence.is_gone.any():
        return None
    last_without = int(np.flatnonzero(evidence.is_gone)[-1])
    seen = np.flatnonzero(evidence.is_there[last_without:])
    first = last_without + int(seen[0]) if len(seen) else len(history) - 1
    without_ns, first_ns = evidence.t_ns[last_without], evidence.t_ns[first]
    return max((without_ns + first_ns) // 2, first_ns - _HIDDEN_NS)


def _weigh(
    pixels: IntArray,
    colours_with: FloatArray,
    colours_without: FloatArray,
    history: Sequence[SeenFrame],
) -> _Evidence | None:
    telling = np.linalg.norm(colours_with - colours_without, axis=1) > SAME_COLOUR
    if telling.sum() < min(_MIN_TELLING, len(pixels)):
        return None
    there, elsewhere = colours_with[telling], colours_without[telling]
    shares = np.array([_shares(seen.at(pixels[telling]), there, elsewhere) for seen in history])
    is_gone = shares[:, 1] >= _WITHOUT_SHARE
    return _Evidence(
        t_ns=[seen.t_ns for seen in history],
        is_there=(shares[:, 0] >= _WITH_SHARE) & ~is_gone,
        is_gone=is_gone,
    )


def _shares(now: FloatArray, there: FloatArray, elsewhere: FloatArray) -> tuple[float, float]:
    """Return which shares of pixels (N, 3) look as with and as without the thing."""
    to_with = np.linalg.norm(now - there, axis=1)
    to_without = np.linalg.norm(now - elsewhere, axis=1)
    is_with = (to_with < SAME_COLOUR) & (to_with < to_without)
    is_without = (to_without < _SAME_TABLE) & (to_without < to_with)
    return float(is_with.mean()), float(is_without.mean())
