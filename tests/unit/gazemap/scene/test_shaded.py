import numpy as np

from gazemap.geometry.camera import Camera
from gazemap.scene.shaded import look_at, shaded_view
from gazemap.scene.surface import table_mesh

CAMERA = Camera(
    width_px=81,
    height_px=61,
    K=np.array([[60.0, 0, 40], [0, 60, 30], [0, 0, 1]]),
    distortion=np.zeros(0),
)


def test_a_camera_looks_at_its_target_and_stands_upright():
    eye, target = np.array([1.0, -2.0, 1.5]), np.array([0.2, 0.1, 0.0])
    T_world_cam = look_at(eye, target)
    points = np.array([[0.2, 0.1, 0.0], [0.2, 0.1, 0.1]])
    uv_px = CAMERA.project(T_world_cam.inverse().transform(points))
    assert np.allclose(uv_px[0], [40, 30])
    assert abs(uv_px[1, 0] - 40) < 1e-9
    assert uv_px[1, 1] < 30


def test_the_surface_is_drawn_where_it_is_and_nothing_beside_it():
    mesh = table_mesh(np.array([[-0.3, -0.3], [0.3, 0.3]]))
    drawn = shaded_view(mesh, CAMERA, look_at(np.array([0.0, -0.5, 1.0]), np.zeros(3)))
    assert (drawn[30, 40] < 160).all()
    assert (drawn[0, 0] > 240).all()
