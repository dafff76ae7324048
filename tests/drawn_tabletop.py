"""A drawn tabletop: a grained plane, boxes and flat marks, seen by any camera."""

from dataclasses import dataclass

import cv2
import numpy as np

from gazemap.geometry.arrays import FloatArray, ImageArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Pose
from gazemap.scene.crops import PosedCamera
from gazemap.types.frame import Frame

_SIDES = ((0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6), (4, 5, 7, 6))


@dataclass(frozen=True, kw_only=True)
class DrawnBox:
    centre: tuple[float, float, float]
    yaw_rad: float
    size_m: tuple[float, float, float]
    bgr: tuple[int, int, int]

    def corners_world(self) -> FloatArray:
        signs = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]) / 2
        c, s = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        turned = (signs * self.size_m) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
        return turned + self.centre


class Tabletop:
    """Draws by painter's algorithm; shares no code with what is tested but the cameras."""

    def __init__(self, boxes: list[DrawnBox], marks_xy: list[tuple[float, float]]) -> None:
        self.boxes, self.marks_xy = boxes, marks_xy
        self.from_above: ImageArray | None = None
        self._rng = np.random.default_rng(3)

    def draw(self, view: PosedCamera) -> ImageArray:
        camera = view.camera
        v, u = np.mgrid[0 : camera.height_px, 0 : camera.width_px]
        xy = view.on_plane(np.stack([u, v], -1).reshape(-1, 2).astype(float))
        grain = 18 * np.sin(70 * xy[:, 0] + 6 * np.sin(15 * xy[:, 1]))
        image = np.array([70.0, 115.0, 160.0]) + grain[:, None] * np.array([0.6, 0.8, 1.0])
        for mark in self.marks_xy:
            image[np.linalg.norm(xy - mark, axis=1) < 0.012] = (120, 90, 60)
        image = np.nan_to_num(image, nan=90.0).reshape(camera.height_px, camera.width_px, 3)
        order = sorted(self.boxes, key=lambda b: -np.linalg.norm(b.centre - view.p_world_cam))
        for box in order:
            self._paint(image, box, view)
        image += self._rng.normal(0, 1.5, image.shape)
        return np.clip(image, 0, 255).astype(np.uint8)

    def _paint(self, image: FloatArray, box: DrawnBox, view: PosedCamera) -> None:
        corners = box.corners_world()
        uv = view.project(corners)
        for k, side in enumerate(_SIDES):
            points = corners[list(side)]
            normal = np.cross(points[1] - points[0], points[3] - points[0])
            if normal @ (view.p_world_cam - points[0]) > 0:
                shade = (0.55, 0.65, 0.75, 0.6, 1.0)[k]
                outline = np.round(uv[list(side)] * 16).astype(np.int32)
                colour = tuple(shade * c for c in box.bgr)
                cv2.fillConvexPoly(image, outline, colour, cv2.LINE_AA, 4)


def looking_at(eye: FloatArray, target: FloatArray) -> Pose:
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return Pose(R=np.stack([right, np.cross(forward, right), forward], axis=1), t=eye)


def head_pose(k: int) -> Pose:
    eye = np.array([0.12 * np.sin(0.9 * k), -0.65 + 0.04 * np.cos(k), 0.52])
    return looking_at(eye, np.array([0.0, 0.02, 0.0]))


@dataclass(kw_only=True)
class Rig:
    head_camera: Camera
    overhead_camera: Camera
    T_world_overhead: Pose

    def overhead(self, table: Tabletop, k: int) -> Frame:
        if table.from_above is None:
            view = PosedCamera.of(self.overhead_camera, self.T_world_overhead, is_overhead=True)
            table.from_above = table.draw(view)
        return Frame(index=k, t_ns=k * 100_000_000, image=table.from_above)

    def head(self, table: Tabletop, k: int) -> tuple[Frame, Pose]:
        T_world_cam = head_pose(k)
        view = PosedCamera.of(self.head_camera, T_world_cam, is_overhead=False)
        return Frame(index=k, t_ns=k * 100_000_000, image=table.draw(view)), T_world_cam
