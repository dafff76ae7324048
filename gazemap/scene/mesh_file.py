"""Meshes as PLY files, which every viewer opens."""

from pathlib import Path

import numpy as np

from gazemap.session.atomic import whole_file
from gazemap.types.scene import Mesh, SurfaceKind

_VERTEX = np.dtype(
    [("xyz", "<f4", 3), ("rgb", "u1", 3), ("kind", "u1")],
)
_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])


def write_mesh(mesh: Mesh, path: Path) -> None:
    """Write a mesh with its colours and with how each vertex is known, whole or not at all.

    Source:
        Turk 1994, the PLY format; viewers skip properties that they do not know.
    """
    vertices = np.empty(len(mesh.vertices_world), dtype=_VERTEX)
    vertices["xyz"], vertices["rgb"] = mesh.vertices_world, mesh.colours
    vertices["kind"] = SurfaceKind.MEASURED if mesh.kinds is None else mesh.kinds
    faces = np.empty(len(mesh.triangles), dtype=_FACE)
    faces["count"], faces["corners"] = 3, mesh.triangles
    kinds = ", ".join(f"{kind.value} {kind.name.lower()}" for kind in SurfaceKind)
    coordinates = [f"property float {axis}" for axis in "xyz"]
    colours = [f"property uchar {name}" for name in ("red", "green", "blue")]
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"comment kind: {kinds}",
        f"element vertex {len(vertices)}",
        *coordinates,
        *colours,
        "property uchar kind",
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    with whole_file(path) as partial:
        partial.write_bytes(
            ("\n".join(header) + "\n").encode() + vertices.tobytes() + faces.tobytes()
        )
