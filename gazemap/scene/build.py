"""The scene stage: from a session and its path to surface and objects."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gazemap.errors import ConventionError
from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.pose import Overhead, Pose, World
from gazemap.ports import Progress, Session
from gazemap.scene.config import SceneConfig
from gazemap.scene.crops import PosedCamera
from gazemap.scene.live import LiveObjects
from gazemap.scene.rectified import RectifiedTable
from gazemap.scene.surface import TablePainter, joined, table_mesh, with_boxes
from gazemap.scene.surroundings import find_surroundings
from gazemap.scene.sweep import StillView
from gazemap.scene.viewpoints import still_view
from gazemap.types.frame import Frame
from gazemap.types.scene import Mesh, SceneModel
from gazemap.types.session import TagLayout
from gazemap.types.tracking import Trajectory

_DEFAULT_OUTLINE = np.array([[-0.6, -0.4], [0.6, 0.4]])


def build_scene(
    session: Session,
    trajectory: Trajectory,
    *,
    points_world: FloatArray,
    T_world_overhead: Pose[World, Overhead] | None,
    config: SceneConfig,
    progress: Progress,
) -> SceneModel:
    """Return the surface and the objects of a session.

    Args:
        session: the recording.
        trajectory: the path of its head camera; world has the support at z = 0.
        points_world: (M, 3) the sparse map.
        T_world_overhead: the overhead camera's pose, or None without one.
        config: settings.
        progress: told how many overhead frames are done.
    """
    outline_xy = table_outline(session.data.tags, margin_m=config.margin_m)
    flat = table_mesh(outline_xy)
    if session.overhead_camera is not None and T_world_overhead is not None:
        rig = _Watch.from_overhead(session, T_world_overhead, flat, config)
        _replay(session, trajectory, rig, config=config, progress=progress)
    else:
        rig = _replay_heads(session, trajectory, flat, config=config, progress=progress)
    rig.live.finish()
    table = rig.painter.painted()
    around = find_surroundings(
        session,
        trajectory,
        table=table,
        points_world=points_world,
        overhead=_overhead_view(session, T_world_overhead, config),
        config=config,
    )
    background = joined([table, *around.meshes])
    objects = rig.live.objects
    return SceneModel(
        mesh=with_boxes(background, objects),
        background=background,
        objects=objects,
        T_world_overhead=T_world_overhead,
        surface_sigma_m=config.surface_sigma_m,
        measured_sigma_m=around.sigma_m,
    )


def _overhead_view(
    session: Session, T_world_overhead: Pose[World, Overhead] | None, config: SceneConfig
) -> tuple[StillView, ...]:
    """Return what the fixed camera saw first, among the views that see depth together."""
    camera, frame = session.overhead_camera, next(session.overhead_frames(), None)
    if camera is None or frame is None or T_world_overhead is None:
        return ()
    posed = PosedCamera.of(camera, T_world_overhead, is_overhead=True)
    return (still_view(frame, posed, config.sweep),)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Watch:
    """What takes the views from above."""

    live: LiveObjects
    painter: TablePainter

    @staticmethod
    def from_overhead(
        session: Session, T_world_overhead: Pose[World, Overhead], flat: Mesh, config: SceneConfig
    ) -> "_Watch":
        """Watch through the overhead camera."""
        camera = session.overhead_camera
        if camera is None:
            raise ConventionError("_Watch.from_overhead: a session with an overhead camera wanted")
        view = PosedCamera.of(camera, T_world_overhead, is_overhead=True)
        live = LiveObjects(
            camera,
            T_world_overhead,
            config,
            outline_xy=flat.vertices_world[[0, -1], :2],
            marks=session.data.tags,
        )
        return _Watch(live=live, painter=TablePainter(flat, view))

    def add(self, frame: Frame) -> None:
        """Take one frame from above."""
        self.live.add(frame)
        self.painter.add(frame)


def table_outline(tags: TagLayout | None, *, margin_m: float) -> FloatArray:
    """Return opposite corners (2, 2) of the part of the support on which objects may stand."""
    if tags is None or len(tags.tags) < 3:
        return _DEFAULT_OUTLINE
    corners = np.concatenate([t.T_world_tag.transform(t.corners_tag) for t in tags.tags])[:, :2]
    return np.stack([corners.min(axis=0) - margin_m, corners.max(axis=0) + margin_m])


def _replay(
    session: Session,
    trajectory: Trajectory,
    watch: _Watch,
    *,
    config: SceneConfig,
    progress: Progress,
) -> None:
    """Give the frames of both cameras to the objects in the order of time."""
    heads = _spaced(session.scene_frames(), period_s=config.head_period_s)
    head = next(heads, None)
    for frame in session.overhead_frames():
        watch.add(frame)
        while head is not None and head.t_ns <= frame.t_ns:
            T_world_cam = trajectory.at(head.t_ns)
            if T_world_cam is not None:
                watch.live.add_view(head, session.scene_camera, T_world_cam)
            head = next(heads, None)
        progress("scene", frame.index + 1, 0)


def _replay_heads(
    session: Session,
    trajectory: Trajectory,
    flat: Mesh,
    *,
    config: SceneConfig,
    progress: Progress,
) -> _Watch:
    """Find objects from the head camera alone: its frames drawn on the table stand in."""
    outline_xy = flat.vertices_world[[0, -1], :2]
    table = RectifiedTable(outline_xy)
    live = LiveObjects(
        table.camera,
        table.T_world_overhead,
        config,
        outline_xy=outline_xy,
        marks=session.data.tags,
        is_rectified=True,
    )
    view = PosedCamera.of(table.camera, table.T_world_overhead, is_overhead=True)
    watch = _Watch(live=live, painter=TablePainter(flat, view))
    for head in _spaced(session.scene_frames(), period_s=config.rectified_period_s):
        T_world_cam = trajectory.at(head.t_ns)
        if T_world_cam is not None:
            watch.add(table.draw(head, session.scene_camera, T_world_cam))
            live.add_view(head, session.scene_camera, T_world_cam)
        progress("scene", head.index + 1, len(session.scene_t_ns))
    return watch


def _spaced(frames: Iterator[Frame], *, period_s: float) -> Iterator[Frame]:
    last_ns: int | None = None
    for frame in frames:
        if last_ns is None or frame.t_ns - last_ns >= period_s * 1e9:
            last_ns = frame.t_ns
            yield frame
