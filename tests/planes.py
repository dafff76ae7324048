"""A room of textured planes, drawn by homographies: the exact truth for tracking tests.

Independent of the product's simulator: no lens, no noise, nothing but planes seen by a pinhole.
"""

import functools
from dataclasses import dataclass

import cv2
import numpy as np

from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Pose
from gazemap.types.session import LayoutTag

CAMERA = Camera(
    width_px=400, height_px=300, K=[[330, 0, 199.5], [0, 330, 149.5], [0, 0, 1]], distortion=[]
)
FRAME_NS = 33_333_333
_TEXELS = 400


@dataclass(frozen=True)
class Plane:
    """A rectangle: corner + a * x + b * y with a, b in [0, 1]; world coordinates."""

    corner: np.ndarray
    x: np.ndarray
    y: np.ndarray
    texture: np.ndarray

    def moved(self, shift):
        return Plane(self.corner + shift, self.x, self.y, self.texture)


@functools.cache
def textured(seed):
    """Return a texture of blobs at several scales."""
    rng = np.random.default_rng(seed)
    total = np.zeros((_TEXELS, _TEXELS))
    for size in (10, 25, 60, 120):
        coarse = rng.uniform(-1, 1, (size, size)).astype(np.float32)
        total += cv2.resize(coarse, (_TEXELS, _TEXELS), interpolation=cv2.INTER_CUBIC)
    return np.clip(127 + 50 * total, 0, 255).astype(np.uint8)


def plane(corner, x, y, seed):
    return Plane(*(np.array(v, float) for v in (corner, x, y)), textured(seed))


def room(seed=0):
    """Return a table with two upright boards behind it."""
    return [
        plane([-1.5, -0.8, -0.3], [3, 0, 0], [0, 2.4, 0], seed + 3),
        plane([-1.6, 1.3, -0.4], [3.2, 0, 0], [0, 0, 1.6], seed + 4),
        plane([-0.7, -0.5, 0], [1.4, 0, 0], [0, 1.0, 0], seed),
        plane([-0.6, 0.45, 0], [0.5, 0.05, 0], [0, 0, 0.3], seed + 1),
        plane([0.15, 0.4, 0], [0.45, -0.1, 0], [0, 0, 0.35], seed + 2),
    ]


def tag(tag_id, centre, size):
    """Return an AprilTag that lies on the table, and its entry of a layout."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    texture = np.full((_TEXELS, _TEXELS), 255, np.uint8)
    quarter = _TEXELS // 4
    marker = cv2.aruco.generateImageMarker(dictionary, tag_id, 2 * quarter)
    texture[quarter:-quarter, quarter:-quarter] = marker
    # Rows of the texture run along its second axis: as printed, y is up.
    corner = np.array(centre, float) + np.array([-size, size, 0.0])
    sheet = Plane(corner, np.array([2 * size, 0, 0]), np.array([0, -2 * size, 0]), texture)
    return sheet, LayoutTag(tag_id=tag_id, size_m=size, T_world_tag=Pose(R=np.eye(3), t=centre))


def hall():
    """Return two rooms side by side, 2 m apart, that share the floor and the wall."""
    far = [item.moved(np.array([2.0, 0, 0])) for item in room(seed=50)[2:]]
    wide = [
        plane([-1.5, -0.8, -0.3], [5, 0, 0], [0, 2.4, 0], 3),
        plane([-1.6, 1.3, -0.4], [5.2, 0, 0], [0, 0, 1.6], 4),
    ]
    return [*wide, *far, *room()[2:]]


def ring():
    """Return eight walls around a place, every second one further away."""
    walls = []
    for k in range(8):
        a = 2 * np.pi * k / 8
        outwards, along = np.array([np.cos(a), np.sin(a)]), np.array([-np.sin(a), np.cos(a)])
        half = 2.04 * np.tan(np.pi / 8)
        start = (2.0 + 0.5 * (k % 2)) * outwards + half * along
        walls.append(plane([*start, 0], [*(-2 * half * along), 0], [0, 0, 1.6], 100 + k))
    return walls


def turning(count, *, per_turn):
    """Return poses of a walk in a circle that looks outwards."""
    poses = []
    for n in range(count):
        a = 2 * np.pi * n / per_turn
        p = np.array([0.7 * np.cos(a - 0.6), 0.7 * np.sin(a - 0.6), 0.8 + 0.1 * np.sin(3 * a)])
        poses.append(looking(p, p + np.array([np.cos(a), np.sin(a), 0])))
    return poses


def box_front(centre, size, seed=9):
    """Return the face of a carried box, turned towards -y."""
    corner = np.asarray(centre, float) - [size / 2, 0, size / 2]
    return plane(corner, [size, 0, 0], [0, 0, size], seed)


def draw(planes, T_world_cam, camera=CAMERA):
    """Return the grey image; later planes cover earlier ones."""
    image = np.full((camera.height_px, camera.width_px), 90, np.uint8)
    T_cam_world = T_world_cam.inverse()
    for item in planes:
        basis = np.column_stack([item.x, item.y, item.corner])
        H = camera.K @ (T_cam_world.R @ basis + np.outer(T_cam_world.t, [0, 0, 1]))
        H = H @ np.diag([1 / _TEXELS, 1 / _TEXELS, 1])
        size = (camera.width_px, camera.height_px)
        drawn = cv2.warpPerspective(item.texture, H, size, flags=cv2.INTER_AREA)
        inside = np.full_like(item.texture, 255)
        mask = cv2.warpPerspective(inside, H, size, flags=cv2.INTER_NEAREST)
        image[mask > 0] = drawn[mask > 0]
    return image


def looking(position, target):
    """Return the camera at a position (3,) that looks at a target (3,), its x axis level."""
    forward = np.asarray(target, float) - position
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    R = np.column_stack([right, np.cross(forward, right), forward])
    return Pose(R=R, t=np.asarray(position, float))


def swaying(count, *, phase=0.0):
    """Return poses of a head that sways in front of the table."""
    s = np.arange(count) / 30 + phase
    x, y, z = 0.22 * np.sin(1.1 * s), -0.75 + 0.08 * np.sin(0.8 * s), 0.62 + 0.06 * np.cos(1.3 * s)
    return [
        looking(np.array(p), [0.1 * np.sin(0.7 * t), 0.15, 0.0])
        for *p, t in zip(x, y, z, s, strict=True)
    ]
