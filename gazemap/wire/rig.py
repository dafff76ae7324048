"""What a rig sends beside images: gaze, fixations, inertial samples, words, tags."""

import json
import math
from dataclasses import dataclass, field

from gazemap.errors import InputError
from gazemap.geometry.pose import Pose
from gazemap.types.session import (
    Blink,
    Cue,
    Event,
    Fixation,
    GazeSample,
    ImuSample,
    LayoutTag,
    TagLayout,
)
from gazemap.wire.envelope import SCHEMA_VERSION, parse, refusing, vector
from gazemap.wire.generated import gazemap_streams_pb2 as pb
from gazemap.wire.streams import Stream


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionInfo:
    """What a recording says of itself as it begins.

    Attributes:
        name: the session's name.
        wearer_heading_rad: heading about z; 0 looks along +y.
        has_device_fixations: whether the device detects fixations itself.
        info: what info.json holds.
        warnings: what was accepted though it is not as it should be.
    """

    name: str
    wearer_heading_rad: float = 0.0
    has_device_fixations: bool = False
    info: dict[str, object] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()


def encode_session(info: SessionInfo) -> bytes:
    """Return the message of `session`."""
    return pb.SessionInfo(
        version=SCHEMA_VERSION,
        name=info.name,
        wearer_heading_rad=info.wearer_heading_rad,
        has_device_fixations=info.has_device_fixations,
        info_json=json.dumps(info.info),
        warnings=info.warnings,
    ).SerializeToString()


def decode_session(payload: bytes) -> SessionInfo:
    """Read a message of `session`."""
    message = parse(pb.SessionInfo(), payload, stream=Stream.SESSION)
    with refusing(Stream.SESSION):
        info = json.loads(message.info_json or "{}")
    if not isinstance(info, dict):
        raise InputError(
            "info_json is no JSON object", where=Stream.SESSION, todo="correct the publisher"
        )
    return SessionInfo(
        name=message.name,
        wearer_heading_rad=message.wearer_heading_rad,
        has_device_fixations=message.has_device_fixations,
        info=info,
        warnings=tuple(message.warnings),
    )


def encode_gaze(sample: GazeSample) -> bytes:
    """Return the message of `gaze`."""
    return pb.GazeSample(
        version=SCHEMA_VERSION,
        t_ns=sample.t_ns,
        u_px=None if math.isnan(sample.u_px) else sample.u_px,
        v_px=None if math.isnan(sample.v_px) else sample.v_px,
        worn=sample.worn,
        blink=sample.blink,
    ).SerializeToString()


def decode_gaze(payload: bytes) -> GazeSample:
    """Read a message of `gaze`."""
    message = parse(pb.GazeSample(), payload, stream=Stream.GAZE)
    return GazeSample(
        t_ns=message.t_ns,
        u_px=message.u_px if message.HasField("u_px") else math.nan,
        v_px=message.v_px if message.HasField("v_px") else math.nan,
        worn=message.worn,
        blink=message.blink,
    )


def encode_device_fixation(fixation: Fixation) -> bytes:
    """Return the message of `device_fixation`."""
    return pb.DeviceFixation(
        version=SCHEMA_VERSION,
        fixation_id=fixation.fixation_id,
        start_ns=fixation.start_ns,
        end_ns=fixation.end_ns,
        u_px=fixation.u_px,
        v_px=fixation.v_px,
    ).SerializeToString()


def decode_device_fixation(payload: bytes) -> Fixation:
    """Read a message of `device_fixation`."""
    message = parse(pb.DeviceFixation(), payload, stream=Stream.DEVICE_FIXATION)
    with refusing(Stream.DEVICE_FIXATION):
        vector([message.u_px, message.v_px], 2, name="u_px, v_px")
    return Fixation(
        fixation_id=message.fixation_id,
        start_ns=message.start_ns,
        end_ns=message.end_ns,
        u_px=message.u_px,
        v_px=message.v_px,
    )


def encode_blink(blink: Blink) -> bytes:
    """Return the message of `blink`."""
    return pb.Blink(
        version=SCHEMA_VERSION, start_ns=blink.start_ns, end_ns=blink.end_ns
    ).SerializeToString()


def decode_blink(payload: bytes) -> Blink:
    """Read a message of `blink`."""
    message = parse(pb.Blink(), payload, stream=Stream.BLINK)
    return Blink(start_ns=message.start_ns, end_ns=message.end_ns)


def encode_event(event: Event) -> bytes:
    """Return the message of `event`."""
    return pb.Event(version=SCHEMA_VERSION, t_ns=event.t_ns, name=event.name).SerializeToString()


def decode_event(payload: bytes) -> Event:
    """Read a message of `event`."""
    message = parse(pb.Event(), payload, stream=Stream.EVENT)
    return Event(t_ns=message.t_ns, name=message.name)


def encode_imu(sample: ImuSample) -> bytes:
    """Return the message of `imu`."""
    return pb.ImuSample(
        version=SCHEMA_VERSION,
        t_ns=sample.t_ns,
        gyro_rad_s=sample.gyro_rad_s,
        accel_m_s2=sample.accel_m_s2,
    ).SerializeToString()


def decode_imu(payload: bytes) -> ImuSample:
    """Read a message of `imu`."""
    message = parse(pb.ImuSample(), payload, stream=Stream.IMU)
    with refusing(Stream.IMU):
        gyro = vector(message.gyro_rad_s, 3, name="gyro_rad_s").tolist()
        accel = vector(message.accel_m_s2, 3, name="accel_m_s2").tolist()
    return ImuSample(t_ns=message.t_ns, gyro_rad_s=tuple(gyro), accel_m_s2=tuple(accel))


def encode_cue(cue: Cue) -> bytes:
    """Return the message of `narration`."""
    return pb.NarrationCue(
        version=SCHEMA_VERSION, start_ns=cue.start_ns, end_ns=cue.end_ns, text=cue.text
    ).SerializeToString()


def decode_cue(payload: bytes) -> Cue:
    """Read a message of `narration`."""
    message = parse(pb.NarrationCue(), payload, stream=Stream.NARRATION)
    return Cue(start_ns=message.start_ns, end_ns=message.end_ns, text=message.text)


def encode_tags(layout: TagLayout) -> bytes:
    """Return the message of `tags`."""
    tags = [
        pb.TagLayout.Tag(
            id=tag.tag_id,
            size_m=tag.size_m,
            position_world=tag.T_world_tag.t,
            orientation_world_xyzw=tag.T_world_tag.quat_xyzw,
        )
        for tag in layout.tags
    ]
    return pb.TagLayout(version=SCHEMA_VERSION, family=layout.family, tags=tags).SerializeToString()


def decode_tags(payload: bytes) -> TagLayout:
    """Read a message of `tags`."""
    message = parse(pb.TagLayout(), payload, stream=Stream.TAGS)
    with refusing(Stream.TAGS):
        tags = tuple(
            LayoutTag(
                tag_id=tag.id,
                size_m=float(vector([tag.size_m], 1, name="size_m")[0]),
                T_world_tag=Pose.from_quat_xyzw(
                    vector(tag.orientation_world_xyzw, 4, name="orientation_world_xyzw"),
                    vector(tag.position_world, 3, name="position_world"),
                ),
            )
            for tag in message.tags
        )
    return TagLayout(family=message.family, tags=tags)
