"""What a simulated session can be told, and the three presets of difficulty."""

import math
from dataclasses import dataclass, field, replace
from enum import StrEnum

from gazemap.errors import ConfigError
from gazemap.geometry.camera import LensModel
from gazemap.sim.vocabulary import COLOURS_BGR, SHAPES, Relation


class Level(StrEnum):
    """How much the session asks of the estimators."""

    EASY = "easy"
    MEDIUM = "medium"
    HARD = "hard"


@dataclass(frozen=True, slots=True, kw_only=True)
class TabletopConfig:
    """What stands on the table and what may be asked of it.

    Attributes:
        colours: words for colours, all in `COLOURS_BGR`.
        shapes: words for shapes, all in `SHAPES`.
        object_count: how many of the pairs of a colour and a shape are on the table.
        relations: where a thing may be put relative to another.
        grain_contrast: 1 for a strongly grained table top, 0 for a plain one.
        speck_count: small coloured marks on the table top.
    """

    colours: tuple[str, ...] = ("red", "blue", "yellow")
    shapes: tuple[str, ...] = ("cell", "block", "cube")
    object_count: int = 8
    relations: tuple[Relation, ...] = tuple(Relation)
    grain_contrast: float = 1.0
    speck_count: int = 60

    def __post_init__(self) -> None:
        """Refuse words that the simulator cannot draw."""
        for known, asked in ((COLOURS_BGR, self.colours), (SHAPES, self.shapes)):
            if wrong := sorted(set(asked) - set(known)):
                raise ConfigError(f"sim: {wrong} is not among {sorted(known)}")
        most = len(set(self.colours)) * len(set(self.shapes))
        if not 2 <= self.object_count <= min(most, 12):
            raise ConfigError(
                f"sim: object_count {self.object_count} is not in 2 .. {min(most, 12)}"
            )
        if not self.relations:
            raise ConfigError("sim: at least one relation is needed")


@dataclass(frozen=True, slots=True, kw_only=True)
class PersonConfig:
    """How the person looks, talks and reaches.

    Attributes:
        has_hand: whether a hand and an arm carry the objects (without: they fly).
        gaze_noise_deg: white noise of one gaze sample and axis.
        gaze_offset_deg: size of the constant error of the eye tracker; its direction is drawn.
        stray_share: how many fixations within an action are elsewhere.
        reference_share: how many fixations while placing are on the thing placed next to.
        speech_delay_s: how long after an action's start its sentence starts.
        speech_sigma_s: the spread of that delay.
        blinks_per_s: rate of blinks.
    """

    has_hand: bool = False
    gaze_noise_deg: float = 0.2
    gaze_offset_deg: float = 0.3
    stray_share: float = 0.12
    reference_share: float = 0.22
    speech_delay_s: float = 0.02
    speech_sigma_s: float = 0.12
    blinks_per_s: float = 0.17


@dataclass(frozen=True, slots=True, kw_only=True)
class LensConfig:
    """A camera: focal length and principal point for an image 800 wide, scaled to the width.

    Attributes:
        width_px: width of the image.
        height_px: height of the image.
        rate_hz: frames a second.
        focal_px: focal lengths (x, y) at a width of `nominal_width_px`.
        centre_offset_px: principal point minus image centre, at that width.
        distortion: coefficients in OpenCV's order.
        model: the lens model.
        serial: serial number as written.
    """

    width_px: int
    height_px: int
    rate_hz: float
    focal_px: tuple[float, float]
    nominal_width_px: int
    centre_offset_px: tuple[float, float]
    distortion: tuple[float, ...]
    model: LensModel = LensModel.PINHOLE
    serial: str = ""

    def __post_init__(self) -> None:
        """Refuse what H.264 cannot hold, and pictures too small to show anything."""
        odd = self.width_px % 2 or self.height_px % 2
        if odd or min(self.width_px, self.height_px) < 64 or self.rate_hz <= 0:
            raise ConfigError(
                f"sim: {self.width_px} x {self.height_px} at {self.rate_hz} a second is no video; "
                "even sides of at least 64 and a positive rate are"
            )


SCENE_LENS = LensConfig(
    width_px=800,
    height_px=600,
    rate_hz=30.0,
    focal_px=(560.0, 559.2),
    nominal_width_px=800,
    centre_offset_px=(1.8, -1.7),
    distortion=(-0.128, 0.107, 0.0003, -0.0006, 0.0003, 0.17, 0.053, 0.024),
    serial="sim-scene",
)
OVERHEAD_LENS = LensConfig(
    width_px=960,
    height_px=720,
    rate_hz=10.0,
    focal_px=(820.0, 821.0),
    nominal_width_px=960,
    centre_offset_px=(1.5, -1.5),
    distortion=(0.05, -0.08, 0.0004, 0.0002, 0.0),
    serial="sim-overhead",
)
# One lens of each kind that a scene camera file may hold; `8` is the default.
LENSES: dict[str, tuple[LensModel, tuple[float, ...]]] = {
    "pinhole4": (LensModel.PINHOLE, (-0.11, 0.06, 0.0004, -0.0003)),
    "pinhole5": (LensModel.PINHOLE, (-0.12, 0.08, 0.0004, -0.0003, -0.01)),
    "pinhole8": (LensModel.PINHOLE, SCENE_LENS.distortion),
    "pinhole14": (
        LensModel.PINHOLE,
        (*SCENE_LENS.distortion, 0.0006, -0.0004, 0.0005, 0.0003, 0.004, -0.003),
    ),
    "fisheye": (LensModel.FISHEYE, (0.02, -0.012, 0.004, -0.001)),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class ImagingConfig:
    """What a camera does to the light.

    Attributes:
        readout_s: rolling shutter of the head camera, first row to last; 0 for a global shutter.
        exposure_s: for how long a row is exposed; 0 for no motion blur.
        light_change: relative size of slow changes of brightness.
        noise_levels: standard deviation of a pixel, in grey levels of 255.
        crf: constant rate factor of the video; smaller is better.
    """

    readout_s: float = 0.0
    exposure_s: float = 0.0
    light_change: float = 0.0
    noise_levels: float = 1.5
    crf: int = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class SimConfig:
    """A simulated session.

    Attributes:
        seed: everything that is drawn follows from it.
        level: name of the preset, written into the truth.
        seconds: length of the session; as many pairs of pick and place as fit are done in it.
        gaze_rate_hz: rate of the eye tracker.
        has_overhead: whether there is a camera above the table.
    """

    seed: int = 0
    level: Level = Level.EASY
    seconds: float = 20.0
    gaze_rate_hz: float = 200.0
    has_overhead: bool = True
    tabletop: TabletopConfig = field(default_factory=TabletopConfig)
    person: PersonConfig = field(default_factory=PersonConfig)
    imaging: ImagingConfig = field(default_factory=ImagingConfig)
    scene_lens: LensConfig = SCENE_LENS
    overhead_lens: LensConfig = OVERHEAD_LENS

    def __post_init__(self) -> None:
        """Refuse sessions too short for one pick and one place."""
        if self.seconds < 6.0:
            raise ConfigError(
                f"sim: seconds {self.seconds} is below 6, too short to pick and place"
            )
        if not math.isfinite(self.seconds):
            raise ConfigError(f"sim: seconds {self.seconds} is no length")
        if self.seed < 0:
            raise ConfigError(f"sim: seed {self.seed} is negative")
        if self.gaze_rate_hz <= 0:
            raise ConfigError(f"sim: gaze_rate_hz {self.gaze_rate_hz} is not positive")


def preset(level: Level) -> SimConfig:
    """Return the session of a level; seed, length and cameras are then replaced as wanted."""
    match level:
        case Level.EASY:
            return SimConfig()
        case Level.MEDIUM:
            person = PersonConfig(has_hand=True, gaze_noise_deg=0.3, gaze_offset_deg=0.8)
            return SimConfig(level=level, person=person)
        case Level.HARD:
            return SimConfig(
                level=level,
                person=PersonConfig(has_hand=True, gaze_noise_deg=0.5, gaze_offset_deg=1.5),
                tabletop=TabletopConfig(grain_contrast=0.35, speck_count=20),
                imaging=ImagingConfig(
                    readout_s=0.012, exposure_s=0.010, light_change=0.22, noise_levels=2.5
                ),
            )


def resized(lens: LensConfig, *, width_px: int, height_px: int, rate_hz: float) -> LensConfig:
    """Return the same lens before another sensor; the field of view across stays."""
    return replace(lens, width_px=width_px, height_px=height_px, rate_hz=rate_hz)
