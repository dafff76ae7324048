"""The keys of the bus: `gazemap/v1/<rig>/<stream>`."""

from enum import StrEnum
from typing import Final

PREFIX: Final = "gazemap/v1"


class Stream(StrEnum):
    """Every stream and queryable; the names are promises."""

    HEAD_IMAGE = "head/image"
    HEAD_CALIBRATION = "head/calibration"
    OVERHEAD_IMAGE = "overhead/image"
    OVERHEAD_CALIBRATION = "overhead/calibration"
    GAZE = "gaze"
    DEVICE_FIXATION = "device_fixation"
    IMU = "imu"
    NARRATION = "narration"
    DEPTH = "depth"

    POSE = "pose"
    FIXATION = "fixation"
    OBJECT = "object"
    MAP_POINTS = "map/points"
    MAP_MESH = "map/mesh"
    MAP_EVENT = "map/event"
    MAPPING_STATUS = "mapping/status"

    PLAN = "plan"
    INSTRUCTION = "instruction"
    SYMBOLS = "symbols"
    QUESTION = "question"
    GROUNDING_STATUS = "grounding/status"

    PARSE = "parse"
    GROUND = "ground"
    CLASSIFY = "classify"
    TEACH = "teach"


# Images may be dropped and are never repeated; everything else is small and must arrive.
LOSSY: Final = frozenset(
    {Stream.HEAD_IMAGE, Stream.OVERHEAD_IMAGE, Stream.DEPTH, Stream.MAP_POINTS, Stream.MAP_MESH}
)


def key(rig: str, stream: Stream) -> str:
    """Return the key of a rig's stream."""
    return f"{PREFIX}/{rig}/{stream.value}"


def alive_key(rig: str, service: str) -> str:
    """Return the key of a service's liveliness token."""
    return f"{PREFIX}/{rig}/alive/{service}"


def stream_of(rig: str, full_key: str) -> Stream | None:
    """Return the stream of a key, or None where it is none of this rig's."""
    name = full_key.removeprefix(f"{PREFIX}/{rig}/")
    return next((each for each in Stream if each.value == name), None)
