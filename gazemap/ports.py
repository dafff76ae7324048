"""What the stages need of one another, so that slam, scene, gaze and sim never meet."""

from collections.abc import Iterator
from typing import Protocol

from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.camera import Camera
from gazemap.types.frame import DepthFrame, Frame
from gazemap.types.scene import Miss, SurfaceHit
from gazemap.types.session import SessionData


class Session(Protocol):
    """A recording, whatever its format; videos are decoded anew by each call, in time order."""

    @property
    def data(self) -> SessionData:
        """Everything but the images."""

    @property
    def scene_camera(self) -> Camera:
        """The head camera."""

    @property
    def scene_t_ns(self) -> tuple[int, ...]:
        """The times of all scene frames."""

    def scene_frames(self) -> Iterator[Frame]:
        """Yield the head camera's frames (BGR, or grey where the recording is grey)."""

    @property
    def overhead_camera(self) -> Camera | None:
        """The overhead camera, or None."""

    def overhead_frames(self) -> Iterator[Frame]:
        """Yield the overhead camera's frames; none without one."""

    @property
    def overhead_t_ns(self) -> tuple[int, ...]:
        """The times of all overhead frames; none without the camera."""

    def scene_depth_frames(self) -> Iterator[DepthFrame]:
        """Yield the depth images registered to the head camera; none without them."""

    def overhead_depth_frames(self) -> Iterator[DepthFrame]:
        """Yield the depth images registered to the overhead camera; none without them."""


class SurfaceQuery(Protocol):
    """The scene as rays see it."""

    def cast(
        self, *, t_ns: int, origins_world: FloatArray, directions_world: FloatArray
    ) -> list[SurfaceHit | Miss]:
        """Return the first hit of each ray (N, 3), (N, 3 unit) in the scene as it stood at t_ns."""


class Progress(Protocol):
    """Told how far long work has come."""

    def __call__(self, stage: str, done: int, total: int) -> None:
        """Take one report; total is 0 where it is not known."""
