"""The streams: their names are promises, on the bus as in a recording."""

from enum import StrEnum


class Stream(StrEnum):
    """Every stream and queryable."""

    SESSION = "session"
    TAGS = "tags"
    HEAD_IMAGE = "head/image"
    HEAD_CALIBRATION = "head/calibration"
    OVERHEAD_IMAGE = "overhead/image"
    OVERHEAD_CALIBRATION = "overhead/calibration"
    GAZE = "gaze"
    DEVICE_FIXATION = "device_fixation"
    BLINK = "blink"
    EVENT = "event"
    IMU = "imu"
    NARRATION = "narration"
    DEPTH = "depth"
    OVERHEAD_DEPTH = "overhead/depth"

    POSE = "pose"
    FIXATION = "fixation"
    OBJECT = "object"
    MAP_POINTS = "map/points"
    MAP_MESH = "map/mesh"
    MAP_EVENT = "map/event"
    OVERHEAD_POSE = "map/overhead"
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
