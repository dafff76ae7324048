"""The first walk through the video: corners, their colours, and which frames are blank."""

from dataclasses import dataclass

import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.ports import Progress
from gazemap.slam.config import SlamConfig
from gazemap.slam.keyframes import choose_keyframes
from gazemap.slam.klt import Corners, CornerTracker
from gazemap.slam.moving import coarse_chroma
from gazemap.slam.structure import Structure
from gazemap.slam.video import GreyVideo

# Beyond this angle off the axis x/z magnifies errors too much to be worth anything.
_WIDEST_FLAT = 3.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FollowedCorners:
    """Corners of all frames.

    Attributes:
        corners: one a frame.
        flat: (N, 2) x/z, y/z of each frame's corners.
        colours: (T, 3) uint8 RGB of each track where it was first seen.
        is_blank: (F,) frames that show nothing.
        chroma: the colours of each frame, coarsely; None of grey ones.
    """

    corners: tuple[Corners, ...]
    flat: tuple[FloatArray, ...]
    colours: ImageArray
    is_blank: BoolArray
    chroma: tuple[ImageArray | None, ...]


def follow_corners(
    video: GreyVideo, camera: Camera, *, config: SlamConfig, progress: Progress
) -> FollowedCorners:
    """Follow corners through the whole video."""
    tracker = CornerTracker(config.klt)
    corners, flat, colours, blank, chroma = [], [], [], [], []
    track_count = 0
    for index, grey, image in video.first_pass():
        here = tracker.track(grey)
        flat_here = camera.normalize(here.uv_px)
        usable = (np.abs(flat_here) < _WIDEST_FLAT).all(axis=1)
        fresh = here.track_id >= track_count
        colours.append(_colours(image, here.uv_px[fresh]))
        track_count += int(fresh.sum())
        corners.append(Corners(track_id=here.track_id[usable], uv_px=here.uv_px[usable]))
        flat.append(flat_here[usable])
        blank.append(tracker.is_blank(grey))
        chroma.append(coarse_chroma(image))
        progress("following corners", index + 1, len(video))
    return FollowedCorners(
        corners=tuple(corners),
        flat=tuple(flat),
        colours=np.concatenate(colours) if colours else np.empty((0, 3), dtype=np.uint8),
        is_blank=np.array(blank, dtype=np.bool_),
        chroma=tuple(chroma),
    )


def _colours(image: ImageArray, uv_px: FloatArray) -> ImageArray:
    at = np.round(uv_px).astype(np.int64)
    pixel = image[at[:, 1], at[:, 0]]
    shape: tuple[int, ...] = image.shape
    if len(shape) == 2:
        return np.repeat(pixel[:, None], 3, axis=1)
    return np.ascontiguousarray(pixel[:, ::-1])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Skeleton:
    """The keyframes' structure, and how its numbers follow from the frames'.

    Attributes:
        structure: nothing in it is posed yet.
        frames: (K,) the frame of each keyframe.
        track_of: (T,) the structure's track of each followed track; -1 for those it leaves out.
        uv_px: (M, 2) pixels of the structure's views.
    """

    structure: Structure
    frames: IntArray
    track_of: IntArray
    uv_px: FloatArray


def build_skeleton(followed: FollowedCorners, camera: Camera, *, config: SlamConfig) -> Skeleton:
    """Choose keyframes and gather the tracks that at least two of them see."""
    frames = choose_keyframes(followed.corners, config)
    chosen = [followed.corners[k] for k in frames]
    none = np.empty(0, dtype=np.int64)
    track_id = np.concatenate([c.track_id for c in chosen] or [none])
    counts = np.bincount(track_id, minlength=len(followed.colours))
    track_of = np.full(len(counts), -1, dtype=np.int64)
    shared = np.flatnonzero(counts >= 2)
    track_of[shared] = np.arange(len(shared))
    keyframe = np.repeat(np.arange(len(frames)), [len(c) for c in chosen])
    keep = track_of[track_id] >= 0
    flat = np.concatenate([np.empty((0, 2)), *(followed.flat[k] for k in frames)])
    uv_px = np.concatenate([np.empty((0, 2)), *(c.uv_px for c in chosen)])
    structure = Structure(
        keyframe=keyframe[keep],
        track=track_of[track_id[keep]],
        flat=flat[keep],
        focal_px=float(camera.K[0, 0] + camera.K[1, 1]) / 2,
    )
    return Skeleton(structure=structure, frames=frames, track_of=track_of, uv_px=uv_px[keep])
