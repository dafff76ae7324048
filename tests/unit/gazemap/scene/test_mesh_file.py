import numpy as np

from gazemap.scene.cast import open3d
from gazemap.scene.mesh_file import write_mesh
from gazemap.scene.surface import joined, table_mesh
from gazemap.types.scene import Mesh, SurfaceKind


def test_a_viewer_reads_the_mesh_and_the_file_says_how_each_part_is_known(tmp_path):
    table = table_mesh(np.array([[0.0, 0.0], [0.4, 0.3]]), step_m=0.1)
    wall = Mesh(
        vertices_world=np.array([[0.0, 1, 0], [1, 1, 0], [0, 1, 1]]),
        triangles=np.array([[0, 1, 2]]),
        colours=np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255]], dtype=np.uint8),
        kinds=np.full(3, SurfaceKind.FITTED, dtype=np.uint8),
    )
    both = joined([table, wall])
    write_mesh(both, tmp_path / "scene.ply")
    read = open3d().io.read_triangle_mesh(str(tmp_path / "scene.ply"))
    assert np.allclose(np.asarray(read.vertices), both.vertices_world, atol=1e-6)
    assert (np.asarray(read.triangles) == both.triangles).all()
    assert np.allclose(np.asarray(read.vertex_colors) * 255, both.colours, atol=0.5)
    content = (tmp_path / "scene.ply").read_bytes()
    assert b"comment kind: 0 support, 1 measured, 2 fitted, 3 box\n" in content
    assert both.kinds is not None
    assert set(both.kinds.tolist()) == {SurfaceKind.SUPPORT, SurfaceKind.FITTED}
