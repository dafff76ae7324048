"""Cameras and recordings as grounding's patches see them."""

from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from gazemap.geometry.arrays import FloatArray, ImageArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Overhead, Pose, World
from gazemap.ports import Session
from gazemap.types.frame import Frame
from gazemap.types.slam import SlamResult
from gazemap.wire.images import decode_image, image_time_ns
from gazemap.wire.streams import Stream
from grounding.patches.view import TimedImage


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StandingCamera:
    """A camera that knows where it stands: `grounding.patches.view.PosedCamera`."""

    camera: Camera
    T_world_cam: Pose[World, Cam] | Pose[World, Overhead]

    def project(self, points_world: FloatArray) -> FloatArray:
        """Return pixels (N, 2) on the distorted image of points (N, 3); NaN behind the camera."""
        return self.camera.project(self.T_world_cam.inverse().transform(points_world))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FixedView:
    """The recording of a camera that stands still."""

    camera: StandingCamera
    t_ns: Sequence[int]
    frames: Callable[[], Iterator[Frame]]
    name: str = "overhead"
    is_fixed: bool = True

    def camera_at(self, t_ns: int) -> StandingCamera:  # noqa: ARG002  it stands still
        """Return the camera."""
        return self.camera

    def images(self, times_ns: Sequence[int]) -> Iterator[TimedImage]:
        """Yield the images of these times in ascending order."""
        return _images(self.frames(), times_ns)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HeadView:
    """The recording of the head camera along its path."""

    session: Session
    slam: SlamResult
    name: str = "head"
    is_fixed: bool = False

    @property
    def t_ns(self) -> Sequence[int]:
        """The times of the frames that have a pose."""
        times: list[int] = self.slam.trajectory.t_ns.tolist()
        return times

    def camera_at(self, t_ns: int) -> StandingCamera | None:
        """Return the camera as it stood; None where it was lost."""
        T_world_cam = self.slam.trajectory.at(t_ns)
        if T_world_cam is None:
            return None
        return StandingCamera(camera=self.slam.camera, T_world_cam=T_world_cam)

    def images(self, times_ns: Sequence[int]) -> Iterator[TimedImage]:
        """Yield the images of these times in ascending order."""
        return _images(self.session.scene_frames(), times_ns)


def _images(frames: Iterator[Frame], times_ns: Sequence[int]) -> Iterator[TimedImage]:
    wanted, last = frozenset(times_ns), max(times_ns, default=-1)
    for frame in frames:
        if frame.t_ns > last:
            return
        if frame.t_ns in wanted:
            yield TimedImage(t_ns=frame.t_ns, image_bgr=_in_colour(frame.image))


def _in_colour(image: ImageArray) -> ImageArray:
    if image.ndim == 3:
        return image
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR), dtype=np.uint8)


class BufferedView:
    """The last images of a live overhead camera, kept as they were compressed."""

    name = "overhead"
    is_fixed = True

    def __init__(self, *, limit: int) -> None:
        """Keep at most `limit` images: the oldest go first."""
        self._payloads: OrderedDict[int, bytes] = OrderedDict()
        self._limit = limit
        self.camera: StandingCamera | None = None

    @property
    def t_ns(self) -> Sequence[int]:
        """The times of the kept images."""
        return tuple(self._payloads)

    def clear(self) -> None:
        """Forget the images."""
        self._payloads.clear()

    def add(self, payload: bytes) -> None:
        """Keep an image message."""
        self._payloads[image_time_ns(payload, stream=Stream.OVERHEAD_IMAGE)] = payload
        while len(self._payloads) > self._limit:
            self._payloads.popitem(last=False)

    def camera_at(self, t_ns: int) -> StandingCamera | None:  # noqa: ARG002  it stands still
        """Return the camera; None until it has been located."""
        return self.camera

    def images(self, times_ns: Sequence[int]) -> Iterator[TimedImage]:
        """Yield the images of these times in ascending order."""
        for t_ns in times_ns:
            frame = decode_image(self._payloads[t_ns], stream=Stream.OVERHEAD_IMAGE)
            yield TimedImage(t_ns=t_ns, image_bgr=_in_colour(frame.image))
