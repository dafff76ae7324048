"""Pictures of the scene: the surface from two sides, the table from above, the overhead view."""

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Polygon
from scipy.stats import chi2

from gazemap.geometry.arrays import FloatArray, ImageArray
from gazemap.types.fixation import Fixation3D
from gazemap.types.scene import SceneModel, SceneObject
from gazemap.types.tracking import Trajectory
from services.rebuild.outputs import Membership
from services.report.picture import instruction_colour

_MESH_POINT_COUNT = 40_000
_VIEWS_DEG = ((28.0, -115.0), (28.0, -35.0))
_ELLIPSE_SCALE = float(np.sqrt(chi2.ppf(0.95, 2)))
Memberships = Mapping[int, Membership]


def surface_figure(
    scene: SceneModel, trajectory: Trajectory, fixations: Sequence[Fixation3D]
) -> Figure:
    """Return the mesh with the head camera's path and the fixations, from two sides."""
    figure = Figure(figsize=(13, 6), layout="constrained")
    step = max(1, len(scene.mesh.vertices_world) // _MESH_POINT_COUNT)
    vertices = scene.mesh.vertices_world[::step]
    colours = scene.mesh.colours[::step] / 255.0
    hits = _points(fixations)
    for k, (elevation, azimuth) in enumerate(_VIEWS_DEG):
        axes = figure.add_subplot(1, 2, k + 1, projection="3d")
        axes.scatter(*vertices.T, c=colours, s=1.5, linewidths=0)
        axes.plot(*trajectory.p_world_cam.T, color="black", linewidth=1.0, label="head camera")
        axes.scatter(*hits.T, c="#D55E00", s=14, label="fixations", depthshade=False)
        axes.set(xlabel="x", ylabel="y", zlabel="z")
        axes.view_init(elev=elevation, azim=azimuth)
        _equal_axes(axes, np.vstack([vertices, trajectory.p_world_cam]))
        if k == 0:
            axes.legend(loc="upper left")
    return figure


def _equal_axes(axes: Axes, points: FloatArray) -> None:
    low, high = np.percentile(points, [0.5, 99.5], axis=0)
    high = np.maximum(high, low + 0.05)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low)


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
        axes.annotate(each.object_id.removeprefix("object-"), tuple(corners.mean(axis=0)))
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
    image: ImageArray, fixations: Sequence[Fixation3D], memberships: Memberships
) -> ImageArray:
    """Return the overhead view (H, W, 3) BGR with the fixations drawn into it."""
    drawn = image.copy() if image.ndim == 3 else cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
    for each in fixations:
        if each.overhead_uv_px is None:
            continue
        member = memberships.get(each.fixation.fixation_id)
        colour = instruction_colour(None if member is None else member.instruction)
        bgr = tuple(int(colour[i : i + 2], 16) for i in (5, 3, 1))
        u, v = np.rint(each.overhead_uv_px).astype(int).tolist()
        cv2.circle(drawn, (u, v), 7, (255, 255, 255), 4, cv2.LINE_AA)
        cv2.circle(drawn, (u, v), 7, bgr, 2, cv2.LINE_AA)
    return np.asarray(drawn, dtype=np.uint8)


def _points(fixations: Sequence[Fixation3D]) -> FloatArray:
    hits = [each.point_world for each in fixations if each.point_world is not None]
    return np.array(hits, dtype=np.float64).reshape(-1, 3)
