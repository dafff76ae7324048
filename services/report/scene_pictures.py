"""Pictures of the scene: the surface from two sides, the table from above, the overhead view."""

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Polygon
from scipy.stats import chi2

from gazemap.geometry.arrays import FloatArray, ImageArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.scene.crops import PosedCamera, as_bgr
from gazemap.scene.shaded import look_at, shaded_view
from gazemap.scene.surface import box_vertices
from gazemap.types.fixation import Fixation3D
from gazemap.types.scene import SceneModel, SceneObject
from gazemap.types.tracking import Trajectory
from services.rebuild.outputs import Membership
from services.report.picture import instruction_colour

_SIDES_RAD = tuple(np.radians([-115.0, -35.0]))
_RISE = 0.75  # how high above the middle the views are taken, as a share of their distance
_VIEW = Camera(
    width_px=900,
    height_px=640,
    K=np.array([[800.0, 0.0, 449.5], [0.0, 800.0, 319.5], [0.0, 0.0, 1.0]]),
    distortion=np.zeros(0),
)
_PATH_BGR, _LOOK_BGR, _WHITE = (60, 60, 60), (0, 94, 213), (255, 255, 255)
_ELLIPSE_SCALE = float(np.sqrt(chi2.ppf(0.95, 2)))
Memberships = Mapping[int, Membership]


def surface_pictures(
    scene: SceneModel, trajectory: Trajectory, fixations: Sequence[Fixation3D]
) -> list[ImageArray]:
    """Return the mesh with the head camera's path and the fixations (H, W, 3) BGR, two sides."""
    hits, path = _points(fixations), trajectory.p_world_cam
    around = np.vstack([hits, path, *(t.T_world_body.t for o in scene.objects for t in o.track)])
    if len(around) == 0:
        around = scene.mesh.vertices_world
    low, high = np.percentile(around, [2, 98], axis=0)
    middle, size = (low + high) / 2, max(float(np.linalg.norm(high - low)), 1e-6)
    pictures = []
    for azimuth in _SIDES_RAD:
        aside = np.array([np.cos(azimuth), np.sin(azimuth), _RISE])
        T_world_cam = look_at(middle + 1.35 * size * aside, middle)
        drawn = shaded_view(scene.mesh, _VIEW, T_world_cam)
        _draw_path(drawn, _projected(path, T_world_cam))
        for uv_px in _projected(hits, T_world_cam):
            _draw_dot(drawn, uv_px, _LOOK_BGR, radius_px=4)
        pictures.append(drawn)
    return pictures


def _projected(points_world: FloatArray, T_world_cam: Pose[World, Cam]) -> FloatArray:
    uv_px = _VIEW.project(T_world_cam.inverse().transform(points_world.reshape(-1, 3)))
    return uv_px[np.isfinite(uv_px).all(axis=1)]


def _draw_path(drawn: ImageArray, uv_px: FloatArray) -> None:
    line = [np.rint(uv_px).astype(np.int32).reshape(-1, 1, 2)]
    for colour, width in ((_WHITE, 4), (_PATH_BGR, 2)):
        cv2.polylines(drawn, line, isClosed=False, color=colour, thickness=width, lineType=16)


def _draw_dot(
    drawn: ImageArray, uv_px: FloatArray, bgr: tuple[int, int, int], *, radius_px: int
) -> None:
    u, v = np.rint(uv_px).astype(int).tolist()
    cv2.circle(drawn, (u, v), radius_px + 1, _WHITE, -1, cv2.LINE_AA)
    cv2.circle(drawn, (u, v), radius_px, bgr, -1, cv2.LINE_AA)


def table_figure(
    scene: SceneModel, fixations: Sequence[Fixation3D], memberships: Memberships, *, unit: str
) -> Figure:
    """Return the table from above: objects where they stood, fixations with their 95 % ellipses."""
    figure = Figure(figsize=(9.5, 7), layout="constrained")
    axes = figure.add_subplot()
    for each in scene.objects:
        _draw_object(axes, each)
    for fixation in fixations:
        if fixation.point_world is None or fixation.cov_world is None:
            continue
        member = memberships.get(fixation.fixation.fixation_id)
        colour = instruction_colour(None if member is None else member.instruction)
        axes.plot(*fixation.point_world[:2], "o", color=colour, markersize=3)
        axes.add_patch(_ellipse(fixation.point_world, fixation.cov_world, colour))
    axes.set(xlabel=f"x [{unit}]", ylabel=f"y [{unit}]", aspect="equal")
    axes.set_title("objects (start solid, later dashed), fixations with 95 % ellipses")
    axes.grid(alpha=0.2)
    return figure


def _draw_object(axes: Axes, each: SceneObject) -> None:
    blue, green, red = np.clip(each.mean_bgr / 255.0, 0, 1)
    for k, state in enumerate(each.track):
        half = each.size_m / 2
        square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * half
        corners = state.T_world_body.transform(square)[:, :2]
        style = {"facecolor": (red, green, blue, 0.8 if k == 0 else 0.3), "edgecolor": "black"}
        axes.add_patch(Polygon(corners, closed=True, linestyle="-" if k == 0 else "--", **style))
        # Beside the box, not on it: what stands on another would cover its number.
        beside = tuple(corners[corners[:, 0].argmax()])
        name = each.object_id.removeprefix("object-")
        axes.annotate(name, beside, xytext=(3, -3), textcoords="offset points")
    if len(each.track) > 1:
        path = np.array([state.T_world_body.t[:2] for state in each.track])
        axes.plot(*path.T, ":", color="black", linewidth=0.8)


def _ellipse(point: FloatArray, cov: FloatArray, colour: str) -> Ellipse:
    values, vectors = np.linalg.eigh(cov[:2, :2])
    width, height = 2 * _ELLIPSE_SCALE * np.sqrt(np.maximum(values[::-1], 0.0))
    angle_deg = float(np.degrees(np.arctan2(vectors[1, 1], vectors[0, 1])))
    centre = (float(point[0]), float(point[1]))
    return Ellipse(centre, width, height, angle=angle_deg, fill=False, color=colour, alpha=0.6)


def overhead_picture(
    image: ImageArray,
    view: PosedCamera,
    scene: SceneModel,
    fixations: Sequence[Fixation3D],
    memberships: Memberships,
) -> ImageArray:
    """Return the overhead view (H, W, 3) BGR with the objects, the fixations and their ellipses.

    Objects are outlined where they first stood; ellipses hold 95 %.
    """
    drawn = as_bgr(image).copy()
    for thing in scene.objects:
        _outline(drawn, view, thing)
    for each in fixations:
        if each.overhead_uv_px is None or each.point_world is None or each.cov_world is None:
            continue
        member = memberships.get(each.fixation.fixation_id)
        colour = instruction_colour(None if member is None else member.instruction)
        bgr = (int(colour[5:7], 16), int(colour[3:5], 16), int(colour[1:3], 16))
        border = [np.rint(_border(view, each.point_world, each.cov_world)).astype(np.int32)]
        for ink, width in ((_WHITE, 3), (bgr, 1)):
            cv2.polylines(drawn, border, isClosed=True, color=ink, thickness=width, lineType=16)
        _draw_dot(drawn, each.overhead_uv_px, bgr, radius_px=2)
    return drawn


def _outline(drawn: ImageArray, view: PosedCamera, thing: SceneObject) -> None:
    corners = thing.track[0].T_world_body.transform(box_vertices(thing.size_m))
    uv_px = view.project(corners)
    if not view.camera.contains(uv_px).all():
        return
    hull = cv2.convexHull(np.rint(uv_px).astype(np.int32))
    for ink, width in (((0, 0, 0), 3), (_WHITE, 1)):
        cv2.polylines(drawn, [hull], isClosed=True, color=ink, thickness=width, lineType=16)
    u, v = np.rint(uv_px.max(axis=0)).astype(int).tolist()
    name = thing.object_id.removeprefix("object-")
    for ink, width in (((0, 0, 0), 4), (_WHITE, 1)):
        cv2.putText(drawn, name, (u, v), cv2.FONT_HERSHEY_SIMPLEX, 0.55, ink, width, cv2.LINE_AA)


def _border(view: PosedCamera, point: FloatArray, cov: FloatArray) -> FloatArray:
    """Return pixels (N, 2) around a point's 95 % ellipse in a view, by its derivative there."""
    step_m = 1e-3
    around = view.project(point + step_m * np.vstack([np.zeros((1, 3)), np.eye(3)]))
    J_px = (around[1:] - around[0]).T / step_m  # (2, 3)
    values, vectors = np.linalg.eigh(J_px @ cov @ J_px.T)
    angles = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    half_axes = _ELLIPSE_SCALE * np.sqrt(np.maximum(values, 0.25))  # never below half a pixel
    return np.asarray(around[0] + (circle * half_axes) @ vectors.T)


def _points(fixations: Sequence[Fixation3D]) -> FloatArray:
    hits = [each.point_world for each in fixations if each.point_world is not None]
    return np.array(hits, dtype=np.float64).reshape(-1, 3)
