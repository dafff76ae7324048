"""The map as others see it: points and the mesh, in Foxglove's schemas."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.TriangleListPrimitive_pb2 import TriangleListPrimitive

from gazemap.errors import InputError
from gazemap.geometry.arrays import FloatArray, ImageArray
from gazemap.types.scene import Mesh
from gazemap.types.tracking import Scale
from gazemap.wire.envelope import (
    SCHEMA_VERSION,
    parse_foxglove,
    refusing,
    time_ns,
    timestamp,
    vector,
)
from gazemap.wire.generated import gazemap_streams_pb2 as pb
from gazemap.wire.streams import Stream

_WORLD: Final = "world"
_MESH_ID: Final = "surface"
_FIXED64: Final = 1  # how protobuf marks a double ...
_LENGTH_DELIMITED: Final = 2  # ... and a message within a message
_POINT: Final = np.dtype(
    [("xyz", "<f4", 3), ("red", "u1"), ("green", "u1"), ("blue", "u1"), ("alpha", "u1")]
)
_FIELDS: Final = [
    PackedElementField(name=name, offset=offset, type=kind)
    for name, offset, kind in (
        ("x", 0, PackedElementField.FLOAT32),
        ("y", 4, PackedElementField.FLOAT32),
        ("z", 8, PackedElementField.FLOAT32),
        ("red", 12, PackedElementField.UINT8),
        ("green", 13, PackedElementField.UINT8),
        ("blue", 14, PackedElementField.UINT8),
        ("alpha", 15, PackedElementField.UINT8),
    )
]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MapPoints:
    """The sparse map.

    Attributes:
        t_ns: the time at which it stood so.
        points_world: (N, 3) metres where the scale is metric; sent as float32.
        colours: (N, 3) uint8 RGB.
        scale: whether lengths are metres.
        map_id: which map it is.
    """

    t_ns: int
    points_world: FloatArray
    colours: ImageArray
    scale: Scale
    map_id: int = 0


def encode_points(points: MapPoints) -> bytes:
    """Return the message of `map/points`."""
    packed = np.zeros(len(points.points_world), dtype=_POINT)
    packed["xyz"] = points.points_world
    for k, name in enumerate(("red", "green", "blue")):
        packed[name] = points.colours[:, k]
    packed["alpha"] = 255
    message = PointCloud(
        timestamp=timestamp(points.t_ns),
        frame_id=_WORLD,
        point_stride=_POINT.itemsize,
        fields=_FIELDS,
        data=packed.tobytes(),
    )
    message.pose.orientation.w = 1.0
    return message.SerializeToString() + _extra(points.scale, points.map_id)


def decode_points(payload: bytes) -> MapPoints:
    """Read a message of `map/points`; only the layout that this module writes is read."""
    message, extra = PointCloud(), pb.MapExtra()
    parse_foxglove(message, extra, payload, stream=Stream.MAP_POINTS)
    layout = [(each.name, each.offset, each.type) for each in message.fields]
    if layout != [(each.name, each.offset, each.type) for each in _FIELDS] or (
        message.point_stride != _POINT.itemsize or len(message.data) % _POINT.itemsize
    ):
        raise InputError(
            "points are not laid out as x, y, z, red, green, blue, alpha",
            where=Stream.MAP_POINTS,
            todo="use the same release of gazemap on both sides",
        )
    packed = np.frombuffer(message.data, dtype=_POINT)
    return MapPoints(
        t_ns=time_ns(message.timestamp),
        points_world=packed["xyz"].astype(np.float64),
        colours=np.column_stack([packed[name] for name in ("red", "green", "blue")]),
        scale=Scale.METRIC if extra.is_metric else Scale.ARBITRARY,
        map_id=extra.map_id,
    )


def encode_mesh(mesh: Mesh, *, t_ns: int, scale: Scale, map_id: int = 0) -> bytes:
    """Return the message of `map/mesh`; a later one replaces it."""
    triangles = TriangleListPrimitive(indices=mesh.triangles.ravel())
    # Objects of Python, one a vertex, would cost a live service a second for each mesh.
    opaque = np.column_stack([mesh.colours / 255, np.ones(len(mesh.colours))])
    points = _repeated(TriangleListPrimitive.POINTS_FIELD_NUMBER, mesh.vertices_world)
    triangles.MergeFromString(points + _repeated(TriangleListPrimitive.COLORS_FIELD_NUMBER, opaque))
    triangles.pose.orientation.w = 1.0
    entity = SceneEntity(
        timestamp=timestamp(t_ns), frame_id=_WORLD, id=_MESH_ID, triangles=[triangles]
    )
    return SceneUpdate(entities=[entity]).SerializeToString() + _extra(scale, map_id)


def _repeated(field_number: int, rows: FloatArray) -> bytes:
    """Return rows (N, K) as a repeated protobuf field of messages with doubles as fields 1 to K."""
    number = np.dtype([("tag", "u1"), ("value", "<f8")])
    packed = np.zeros(
        len(rows), [("tag", "u1"), ("size", "u1"), ("numbers", number, rows.shape[1])]
    )
    packed["tag"] = field_number << 3 | _LENGTH_DELIMITED
    packed["size"] = number.itemsize * rows.shape[1]
    packed["numbers"]["tag"] = np.arange(1, rows.shape[1] + 1) << 3 | _FIXED64
    packed["numbers"]["value"] = rows
    return packed.tobytes()


def decode_mesh(payload: bytes) -> Mesh:
    """Read a message of `map/mesh`."""
    message, extra = SceneUpdate(), pb.MapExtra()
    parse_foxglove(message, extra, payload, stream=Stream.MAP_MESH)
    if len(message.entities) != 1 or len(message.entities[0].triangles) != 1:
        raise InputError(
            "one mesh expected",
            where=Stream.MAP_MESH,
            todo="use the same release of gazemap on both sides",
        )
    triangles = message.entities[0].triangles[0]
    count = len(triangles.points)
    flat = [value for p in triangles.points for value in (p.x, p.y, p.z)]
    indices = np.array(triangles.indices, dtype=np.int64)
    colours = np.array([(c.r, c.g, c.b) for c in triangles.colors]).reshape(-1, 3) * 255
    with refusing(Stream.MAP_MESH):
        if len(colours) != count or len(indices) % 3 or (indices >= count).any():
            raise ValueError("indices or colours do not fit the points")
        return Mesh(
            vertices_world=vector(flat, 3 * count, name="points").reshape(-1, 3),
            triangles=indices.reshape(-1, 3),
            colours=np.rint(colours).astype(np.uint8),
        )


def _extra(scale: Scale, map_id: int) -> bytes:
    return pb.MapExtra(
        version=SCHEMA_VERSION, map_id=map_id, is_metric=scale is Scale.METRIC
    ).SerializeToString()
