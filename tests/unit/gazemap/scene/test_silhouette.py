import cv2
import numpy as np

from gazemap.scene.silhouette import mask_inside, sum_inside

PROJECTION = np.array([[80.0, 0, 20, 20], [0, 80, 20, 20], [0, 0, 1, 1.0]])
SHAPE = np.array([0.02, -0.03, 0.05, 0.6, 0.3, 0.2, 0.1])


def corners_px() -> np.ndarray:
    signs = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]) / 2
    c, s = np.cos(SHAPE[3]), np.sin(SHAPE[3])
    world = (signs * SHAPE[4:]) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T + SHAPE[:3]
    homogeneous = np.column_stack([world, np.ones(8)]) @ PROJECTION.T
    return homogeneous[:, :2] / homogeneous[:, 2:]


def test_a_silhouette_is_the_hull_of_the_corners():
    hull = cv2.convexHull(corners_px().astype(np.float32))
    inside = [[cv2.pointPolygonTest(hull, (u, v), True) for u in range(40)] for v in range(40)]
    expected = np.array(inside)
    mask = mask_inside(SHAPE, PROJECTION, 40)
    assert (mask == (expected >= 0))[np.abs(expected) > 1e-3].all()


def test_ones_inside_sum_to_the_silhouettes_area():
    sums = np.zeros((1, 40, 41))
    np.cumsum(np.ones((1, 40, 40)), axis=2, out=sums[:, :, 1:])
    area = cv2.contourArea(cv2.convexHull(corners_px().astype(np.float32)))
    got = sum_inside(SHAPE, PROJECTION[None], sums)
    assert abs(got - area) < 0.03 * area
    assert got != area  # rows are sampled at their middles, not integrated
