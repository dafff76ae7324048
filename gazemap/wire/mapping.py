"""What the mapping service says: poses, fixations in the scene, objects, events, status."""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.Pose_pb2 import Pose as PoseMessage
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3

from gazemap.errors import InputError
from gazemap.geometry.align import Similarity
from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.pose import Pose
from gazemap.types.fixation import Fixation3D
from gazemap.types.map import MapEvent, MapEventKind
from gazemap.types.scene import HitKind, ObjectState, SceneObject
from gazemap.types.session import Fixation
from gazemap.types.status import Level, ServiceStatus
from gazemap.types.tracking import Scale, Tracked
from gazemap.wire.envelope import (
    SCHEMA_VERSION,
    matrix,
    parse,
    parse_foxglove,
    refusing,
    time_ns,
    timestamp,
    vector,
)
from gazemap.wire.generated import gazemap_streams_pb2 as pb
from gazemap.wire.streams import Stream

WORLD: Final = "world"
_HITS: Final = {
    HitKind.SURFACE: pb.Fixation3D.HIT_SURFACE,
    HitKind.OBJECT: pb.Fixation3D.HIT_OBJECT,
    HitKind.NONE: pb.Fixation3D.HIT_NONE,
}
_KINDS: Final = {
    MapEventKind.NEW_MAP: pb.MapEvent.KIND_NEW_MAP,
    MapEventKind.LOOP_CLOSED: pb.MapEvent.KIND_LOOP_CLOSED,
    MapEventKind.LOST: pb.MapEvent.KIND_LOST,
    MapEventKind.RELOCALISED: pb.MapEvent.KIND_RELOCALISED,
    MapEventKind.RE_ANCHORED: pb.MapEvent.KIND_RE_ANCHORED,
    MapEventKind.MERGED: pb.MapEvent.KIND_MERGED,
}
_LEVELS: Final = {
    Level.OK: pb.ServiceStatus.LEVEL_OK,
    Level.WARNING: pb.ServiceStatus.LEVEL_WARNING,
    Level.ERROR: pb.ServiceStatus.LEVEL_ERROR,
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PublishedPose:
    """A tracked frame, and whether its lengths are metres."""

    tracked: Tracked
    scale: Scale


def encode_pose(pose: PublishedPose) -> bytes:
    """Return the message of `pose`."""
    tracked = pose.tracked
    message = PoseInFrame(
        timestamp=timestamp(tracked.t_ns), frame_id=WORLD, pose=_pose_message(tracked.T_world_cam)
    )
    extra = pb.PoseExtra(
        version=SCHEMA_VERSION,
        map_id=tracked.map_id,
        is_metric=pose.scale is Scale.METRIC,
        is_relocalised=tracked.is_relocalised,
        cov_cam=_flat(tracked.cov_cam),
    )
    return message.SerializeToString() + extra.SerializeToString()


def decode_pose(payload: bytes) -> PublishedPose:
    """Read a message of `pose`."""
    message, extra = PoseInFrame(), pb.PoseExtra()
    parse_foxglove(message, extra, payload, stream=Stream.POSE)
    with refusing(Stream.POSE):
        tracked = Tracked(
            t_ns=time_ns(message.timestamp),
            T_world_cam=_pose(message.pose.orientation, message.pose.position),
            cov_cam=matrix(extra.cov_cam, 6, name="cov_cam") if extra.cov_cam else None,
            map_id=extra.map_id,
            is_relocalised=extra.is_relocalised,
        )
    return PublishedPose(
        tracked=tracked, scale=Scale.METRIC if extra.is_metric else Scale.ARBITRARY
    )


def encode_transform(
    T_parent_child: Pose[Any, Any], *, parent: str, child: str, t_ns: int
) -> bytes:
    """Return a fixed transform, such as that of the overhead camera in world."""
    x, y, z = T_parent_child.t
    return FrameTransform(
        timestamp=timestamp(t_ns),
        parent_frame_id=parent,
        child_frame_id=child,
        translation=Vector3(x=x, y=y, z=z),
        rotation=_quaternion(T_parent_child),
    ).SerializeToString()


def decode_transform(payload: bytes, *, stream: str) -> Pose[Any, Any]:
    """Read a transform."""
    message, extra = FrameTransform(), pb.MapExtra()
    parse_foxglove(message, extra, payload, stream=stream)
    with refusing(stream):
        return _pose(message.rotation, message.translation)


def _pose_message(T_a_b: Pose[Any, Any]) -> PoseMessage:
    message = PoseMessage(orientation=_quaternion(T_a_b))
    message.position.x, message.position.y, message.position.z = T_a_b.t
    return message


def _quaternion(T_a_b: Pose[Any, Any]) -> Quaternion:
    x, y, z, w = T_a_b.quat_xyzw
    return Quaternion(x=x, y=y, z=z, w=w)


def _pose(turn: Quaternion, place: Any) -> Pose[Any, Any]:  # noqa: ANN401  Vector3 or Point3
    return Pose.from_quat_xyzw([turn.x, turn.y, turn.z, turn.w], [place.x, place.y, place.z])


def _flat(array: FloatArray | None) -> list[float]:
    return [] if array is None else np.asarray(array).ravel().tolist()


def encode_fixation(fixation: Fixation3D) -> bytes:
    """Return the message of `fixation`."""
    seen = fixation.fixation
    return pb.Fixation3D(
        version=SCHEMA_VERSION,
        fixation_id=seen.fixation_id,
        start_ns=seen.start_ns,
        end_ns=seen.end_ns,
        u_px=seen.u_px,
        v_px=seen.v_px,
        scene_uv_px=_flat(fixation.scene_uv_px),
        hit=_HITS[fixation.hit],
        point_world=_flat(fixation.point_world),
        cov_world=_flat(fixation.cov_world),
        object_id=fixation.object_id,
        overhead_uv_px=_flat(fixation.overhead_uv_px),
        reason=fixation.reason,
    ).SerializeToString()


def decode_fixation(payload: bytes) -> Fixation3D:
    """Read a message of `fixation`."""
    message = parse(pb.Fixation3D(), payload, stream=Stream.FIXATION)
    hit = next((kind for kind, number in _HITS.items() if number == message.hit), None)
    if hit is None:
        raise _unknown(message.hit, "hit", Stream.FIXATION)
    overhead = message.overhead_uv_px
    with refusing(Stream.FIXATION):
        return Fixation3D(
            fixation=Fixation(
                fixation_id=message.fixation_id,
                start_ns=message.start_ns,
                end_ns=message.end_ns,
                u_px=message.u_px,
                v_px=message.v_px,
            ),
            scene_uv_px=vector(message.scene_uv_px, 2, name="scene_uv_px"),
            hit=hit,
            point_world=vector(message.point_world, 3, name="point_world")
            if message.point_world
            else None,
            cov_world=matrix(message.cov_world, 3, name="cov_world") if message.cov_world else None,
            object_id=message.object_id if message.HasField("object_id") else None,
            overhead_uv_px=vector(overhead, 2, name="overhead_uv_px") if overhead else None,
            reason=message.reason,
        )


def encode_object(thing: SceneObject) -> bytes:
    """Return the message of `object`."""
    track = [
        pb.SceneObject.State(
            t_ns=state.t_ns,
            left_ns=state.left_ns,
            position_world=state.T_world_body.t,
            orientation_world_xyzw=state.T_world_body.quat_xyzw,
            cov_world=_flat(state.cov_world),
        )
        for state in thing.track
    ]
    return pb.SceneObject(
        version=SCHEMA_VERSION,
        object_id=thing.object_id,
        size_m=_flat(thing.size_m),
        track=track,
        mean_bgr=_flat(thing.mean_bgr),
    ).SerializeToString()


def decode_object(payload: bytes) -> SceneObject:
    """Read a message of `object`."""
    message = parse(pb.SceneObject(), payload, stream=Stream.OBJECT)
    with refusing(Stream.OBJECT):
        return SceneObject(
            object_id=message.object_id,
            size_m=vector(message.size_m, 3, name="size_m"),
            track=tuple(_state(state) for state in message.track),
            mean_bgr=vector(message.mean_bgr, 3, name="mean_bgr"),
        )


def _state(state: pb.SceneObject.State) -> ObjectState:
    return ObjectState(
        t_ns=state.t_ns,
        left_ns=state.left_ns if state.HasField("left_ns") else None,
        T_world_body=Pose.from_quat_xyzw(
            vector(state.orientation_world_xyzw, 4, name="orientation_world_xyzw"),
            vector(state.position_world, 3, name="position_world"),
        ),
        cov_world=matrix(state.cov_world, 3, name="cov_world"),
    )


def encode_map_event(event: MapEvent) -> bytes:
    """Return the message of `map/event`."""
    message = pb.MapEvent(
        version=SCHEMA_VERSION,
        t_ns=event.t_ns,
        kind=_KINDS[event.kind],
        map_id=event.map_id,
        old_map_id=event.old_map_id,
    )
    if event.S_new_old is not None:
        message.new_from_old.scale = event.S_new_old.scale
        message.new_from_old.rotation.extend(_flat(event.S_new_old.R))
        message.new_from_old.translation.extend(_flat(event.S_new_old.t))
    return message.SerializeToString()


def decode_map_event(payload: bytes) -> MapEvent:
    """Read a message of `map/event`."""
    message = parse(pb.MapEvent(), payload, stream=Stream.MAP_EVENT)
    kind = next((kind for kind, number in _KINDS.items() if number == message.kind), None)
    if kind is None:
        raise _unknown(message.kind, "kind", Stream.MAP_EVENT)
    moved = message.new_from_old if message.HasField("new_from_old") else None
    with refusing(Stream.MAP_EVENT):
        return MapEvent(
            kind=kind,
            t_ns=message.t_ns,
            map_id=message.map_id,
            old_map_id=message.old_map_id,
            S_new_old=None
            if moved is None
            else Similarity(
                scale=moved.scale,
                R=matrix(moved.rotation, 3, name="rotation"),
                t=vector(moved.translation, 3, name="translation"),
            ),
        )


def encode_status(status: ServiceStatus) -> bytes:
    """Return the message of `mapping/status` or `grounding/status`."""
    return pb.ServiceStatus(
        version=SCHEMA_VERSION,
        t_ns=status.t_ns,
        service=status.service,
        level=_LEVELS[status.level],
        messages=status.messages,
        figures=dict(status.figures),
    ).SerializeToString()


def decode_status(payload: bytes, *, stream: str = "status") -> ServiceStatus:
    """Read a message of `mapping/status` or `grounding/status`."""
    message = parse(pb.ServiceStatus(), payload, stream=stream)
    level = next((kind for kind, number in _LEVELS.items() if number == message.level), None)
    if level is None:
        raise _unknown(message.level, "level", stream)
    return ServiceStatus(
        service=message.service,
        t_ns=message.t_ns,
        level=level,
        messages=tuple(message.messages),
        figures=dict(message.figures),
    )


def _unknown(value: int, name: str, stream: str) -> InputError:
    return InputError(
        f"'{name}' is {value}, which this version does not know",
        where=stream,
        todo="use the same release of gazemap on both sides",
    )
