"""Which images of a camera may be taken: of the camera's size, each after the one before."""

from typing import Final

from gazemap.errors import InputError
from gazemap.geometry.camera import Camera
from gazemap.types.frame import Frame
from gazemap.wire.streams import Stream

# So many in a row that are older than the last one: it was the last one that was wrong.
_CLOCK_SET_COUNT: Final = 15


class ImageGate:
    """Lets a camera's images through in the order of time."""

    def __init__(self, stream: Stream) -> None:
        self._stream = stream
        self.reset()

    def reset(self) -> None:
        """Begin anew: any time may come first."""
        self._last_ns: int | None = None
        self._behind_count = 0

    def check(self, frame: Frame, camera: Camera) -> bool:
        """Return whether the clock goes on from the image before; False: it was set anew.

        Raises:
            InputError: if the image must not be taken.
        """
        height_px, width_px = frame.image.shape[:2]
        if (width_px, height_px) != (camera.width_px, camera.height_px):
            expected = f"{camera.width_px}x{camera.height_px}"
            what = f"an image of {width_px}x{height_px} pixels, {expected} expected"
            todo = "publish images and calibration of one size"
            raise InputError(what, where=self._stream, todo=todo)
        is_behind = self._last_ns is not None and frame.t_ns <= self._last_ns
        self._behind_count = self._behind_count + 1 if is_behind else 0
        if is_behind and self._behind_count < _CLOCK_SET_COUNT:
            what = "an image that is not after the one before"
            todo = "publish each image once, in the order of time"
            raise InputError(what, where=self._stream, todo=todo)
        self._last_ns, self._behind_count = frame.t_ns, 0
        return not is_behind
