"""What patches need of a camera: where a point is in its image, and its images at some times."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

from grounding.types import FloatArray, ImageArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TimedImage:
    """An image (H, W, 3) BGR, as recorded, and its time."""

    t_ns: int
    image_bgr: ImageArray


class PosedCamera(Protocol):
    """A camera that knows where it stands."""

    def project(self, points_world: FloatArray) -> FloatArray:
        """Return pixels (N, 2) on the distorted image of points (N, 3); NaN behind the camera."""


class View(Protocol):
    """A camera's recording."""

    @property
    def name(self) -> str:
        """`overhead` or `head`, as patches.csv has it."""

    @property
    def is_fixed(self) -> bool:
        """Whether the camera stands still, so that images can be compared pixel by pixel."""

    @property
    def t_ns(self) -> Sequence[int]:
        """The times of all images, ascending."""

    def camera_at(self, t_ns: int) -> PosedCamera | None:
        """Return the camera as it stood; None where that is not known."""

    def images(self, times_ns: Sequence[int]) -> Iterator[TimedImage]:
        """Yield the images of these times, which are members of `t_ns`, in ascending order."""
