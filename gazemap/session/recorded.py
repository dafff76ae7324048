"""A session as every reader gives it: sources of frames, and the rest as data."""

from collections.abc import Iterator
from dataclasses import dataclass

from gazemap.geometry.camera import Camera
from gazemap.session.depth import NO_DEPTH, DepthSource
from gazemap.session.frames import FrameSource
from gazemap.types.frame import DepthFrame, Frame
from gazemap.types.session import SessionData


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordedSession:
    """A recording; see `gazemap.ports.Session`."""

    data: SessionData
    scene: FrameSource
    overhead: FrameSource | None = None
    scene_depth: DepthSource = NO_DEPTH
    overhead_depth: DepthSource = NO_DEPTH

    @property
    def scene_camera(self) -> Camera:
        """The head camera."""
        return self.scene.camera

    @property
    def scene_t_ns(self) -> tuple[int, ...]:
        """The times of all scene frames."""
        return self.scene.t_ns

    def scene_frames(self) -> Iterator[Frame]:
        """Yield the head camera's frames."""
        return self.scene.frames()

    @property
    def overhead_camera(self) -> Camera | None:
        """The overhead camera, or None."""
        return None if self.overhead is None else self.overhead.camera

    @property
    def overhead_t_ns(self) -> tuple[int, ...]:
        """The times of all overhead frames; none without the camera."""
        return () if self.overhead is None else self.overhead.t_ns

    def overhead_frames(self) -> Iterator[Frame]:
        """Yield the overhead camera's frames; none without one."""
        return iter(()) if self.overhead is None else self.overhead.frames()

    def scene_depth_frames(self) -> Iterator[DepthFrame]:
        """Yield the depth images registered to the head camera; none without them."""
        return self.scene_depth.frames()

    def overhead_depth_frames(self) -> Iterator[DepthFrame]:
        """Yield the depth images registered to the overhead camera; none without them."""
        return self.overhead_depth.frames()
