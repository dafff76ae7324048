"""What a recording holds beside its videos."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from gazemap.geometry.arrays import BoolArray, FloatArray, IntArray
from gazemap.geometry.pose import Pose, Tag, World


@dataclass(frozen=True, slots=True, kw_only=True)
class GazeSample:
    """One gaze sample as a live device sends it; the pixel is NaN where it gave none."""

    t_ns: int
    u_px: float
    v_px: float
    worn: bool
    blink: bool


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GazeSamples:
    """Gaze in the scene image, sorted by time; NaN pixels and blinks are kept, not dropped.

    Attributes:
        t_ns: (N,) int64, strictly increasing.
        uv_px: (N, 2) on the distorted image; NaN where the device gave none.
        worn: (N,) whether the glasses were worn.
        blink: (N,) whether the device reports a blink.
    """

    t_ns: IntArray
    uv_px: FloatArray
    worn: BoolArray
    blink: BoolArray

    @staticmethod
    def of(samples: Sequence[GazeSample]) -> "GazeSamples":
        """Return samples in time order as arrays."""
        return GazeSamples(
            t_ns=np.array([s.t_ns for s in samples], dtype=np.int64),
            uv_px=np.array([(s.u_px, s.v_px) for s in samples], dtype=np.float64).reshape(-1, 2),
            worn=np.array([s.worn for s in samples], dtype=np.bool_),
            blink=np.array([s.blink for s in samples], dtype=np.bool_),
        )

    def __iter__(self) -> Iterator[GazeSample]:
        rows = zip(
            self.t_ns.tolist(),
            self.uv_px.tolist(),
            self.worn.tolist(),
            self.blink.tolist(),
            strict=True,
        )
        for t_ns, (u_px, v_px), worn, blink in rows:
            yield GazeSample(t_ns=t_ns, u_px=u_px, v_px=v_px, worn=worn, blink=blink)


@dataclass(frozen=True, slots=True, kw_only=True)
class Fixation:
    """A fixation in the scene image, from the device or detected."""

    fixation_id: int
    start_ns: int
    end_ns: int
    u_px: float
    v_px: float

    @property
    def mid_ns(self) -> int:
        """The time at which the fixation is cast."""
        return (self.start_ns + self.end_ns) // 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Blink:
    """An interval without gaze."""

    start_ns: int
    end_ns: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """A named moment that the device wrote down."""

    t_ns: int
    name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Cue:
    """Something that was said; the times are those of the transcript and may be seconds off."""

    start_ns: int
    end_ns: int
    text: str


Vector3 = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class ImuSample:
    """One inertial sample as a live device sends it, in the IMU's frame."""

    t_ns: int
    gyro_rad_s: Vector3
    accel_m_s2: Vector3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ImuSamples:
    """Inertial samples, sorted by time.

    Attributes:
        t_ns: (N,) int64.
        gyro_rad_s: (N, 3) in the IMU's frame.
        accel_m_s2: (N, 3) in the IMU's frame.
    """

    t_ns: IntArray
    gyro_rad_s: FloatArray
    accel_m_s2: FloatArray

    @staticmethod
    def of(samples: Sequence[ImuSample]) -> "ImuSamples":
        """Return samples in time order as arrays."""
        return ImuSamples(
            t_ns=np.array([s.t_ns for s in samples], dtype=np.int64),
            gyro_rad_s=np.array([s.gyro_rad_s for s in samples]).reshape(-1, 3),
            accel_m_s2=np.array([s.accel_m_s2 for s in samples]).reshape(-1, 3),
        )

    def __iter__(self) -> Iterator[ImuSample]:
        for t_ns, gyro, accel in zip(
            self.t_ns.tolist(), self.gyro_rad_s.tolist(), self.accel_m_s2.tolist(), strict=True
        ):
            yield ImuSample(t_ns=t_ns, gyro_rad_s=tuple(gyro), accel_m_s2=tuple(accel))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LayoutTag:
    """An AprilTag that is fixed in the world; size_m is the side of its black square."""

    tag_id: int
    size_m: float
    T_world_tag: Pose[World, Tag]

    @property
    def corners_tag(self) -> FloatArray:
        """Corners (4, 3) in the tag's frame: top-left, top-right, bottom-right, bottom-left."""
        h = self.size_m / 2
        return np.array([[-h, h, 0.0], [h, h, 0.0], [h, -h, 0.0], [-h, -h, 0.0]])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TagLayout:
    """The tags that set the world frame."""

    family: str
    tags: tuple[LayoutTag, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SessionData:
    """Everything of a recording but its images; what it lacks is None or empty.

    Attributes:
        name: the session's name, from its folder or file.
        wearer_heading_rad: heading about z; 0 looks along +y.
        info: what info.json holds.
        warnings: what was accepted though it is not as it should be, one line each.
    """

    name: str
    gaze: GazeSamples | None = None
    fixations: tuple[Fixation, ...] | None = None
    blinks: tuple[Blink, ...] = ()
    events: tuple[Event, ...] = ()
    imu: ImuSamples | None = None
    narration: tuple[Cue, ...] = ()
    tags: TagLayout | None = None
    wearer_heading_rad: float = 0.0
    info: dict[str, object] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
