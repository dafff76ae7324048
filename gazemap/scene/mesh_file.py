"""Meshes as PLY files, which every viewer opens."""

from pathlib import Path

import numpy as np

from gazemap.scene.cast import open3d
from gazemap.session.atomic import whole_file
from gazemap.types.scene import Mesh


def write_mesh(mesh: Mesh, path: Path) -> None:
    """Write a mesh with its colours, whole or not at all."""
    o3d = open3d()
    native = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(mesh.vertices_world),
        o3d.utility.Vector3iVector(mesh.triangles.astype(np.int32)),
    )
    native.vertex_colors = o3d.utility.Vector3dVector(mesh.colours / 255.0)
    with whole_file(path) as partial:
        o3d.io.write_triangle_mesh(str(partial), native)
