"""The scene stage: from a session and its path to surface and objects."""

from collections.abc import Iterator

import numpy as np

from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.pose import Overhead, Pose, World
from gazemap.ports import Progress, Session
from gazemap.scene.config import SceneConfig
from gazemap.scene.live import LiveObjects
from gazemap.scene.rectified import RectifiedTable
from gazemap.scene.surface import table_mesh, with_boxes
from gazemap.types.frame import Frame
from gazemap.types.scene import SceneModel
from gazemap.types.session import TagLayout
from gazemap.types.tracking import Trajectory

_DEFAULT_OUTLINE = np.array([[-0.6, -0.4], [0.6, 0.4]])


def build_scene(
    session: Session,
    trajectory: Trajectory,
    *,
    T_world_overhead: Pose[World, Overhead] | None,
    config: SceneConfig,
    progress: Progress,
) -> SceneModel:
    """Return the surface and the objects of a session.

    Args:
        session: the recording.
        trajectory: the path of its head camera; world has the support at z = 0.
        T_world_overhead: the overhead camera's pose, or None without one.
        config: settings.
        progress: told how many overhead frames are done.
    """
    outline_xy = table_outline(session.data.tags, margin_m=config.margin_m)
    if session.overhead_camera is not None and T_world_overhead is not None:
        live = LiveObjects(
            session.overhead_camera,
            T_world_overhead,
            config,
            outline_xy=outline_xy,
            marks=session.data.tags,
        )
        _replay(session, trajectory, live, config=config, progress=progress)
    else:
        live = _replay_heads(session, trajectory, outline_xy, config=config, progress=progress)
    objects = live.objects
    background = table_mesh(outline_xy)
    return SceneModel(
        mesh=with_boxes(background, objects),
        background=background,
        objects=objects,
        T_world_overhead=T_world_overhead,
        surface_sigma_m=config.surface_sigma_m,
    )


def table_outline(tags: TagLayout | None, *, margin_m: float) -> FloatArray:
    """Return opposite corners (2, 2) of the part of the support on which objects may stand."""
    if tags is None or len(tags.tags) < 3:
        return _DEFAULT_OUTLINE
    corners = np.concatenate([t.T_world_tag.transform(t.corners_tag) for t in tags.tags])[:, :2]
    return np.stack([corners.min(axis=0) - margin_m, corners.max(axis=0) + margin_m])


def _replay(
    session: Session,
    trajectory: Trajectory,
    live: LiveObjects,
    *,
    config: SceneConfig,
    progress: Progress,
) -> None:
    """Give the frames of both cameras to the live objects in the order of time."""
    heads = _spaced(session.scene_frames(), period_s=config.head_period_s)
    head = next(heads, None)
    for frame in session.overhead_frames():
        live.add(frame)
        while head is not None and head.t_ns <= frame.t_ns:
            T_world_cam = trajectory.at(head.t_ns)
            if T_world_cam is not None:
                live.add_view(head, session.scene_camera, T_world_cam)
            head = next(heads, None)
        progress("scene", frame.index + 1, 0)
    live.finish()


def _replay_heads(
    session: Session,
    trajectory: Trajectory,
    outline_xy: FloatArray,
    *,
    config: SceneConfig,
    progress: Progress,
) -> LiveObjects:
    """Find objects from the head camera alone: its frames drawn on the table stand in."""
    table = RectifiedTable(outline_xy)
    live = LiveObjects(
        table.camera,
        table.T_world_overhead,
        config,
        outline_xy=outline_xy,
        marks=session.data.tags,
        is_rectified=True,
    )
    for head in _spaced(session.scene_frames(), period_s=config.rectified_period_s):
        T_world_cam = trajectory.at(head.t_ns)
        if T_world_cam is None:
            continue
        live.add(table.draw(head, session.scene_camera, T_world_cam))
        live.add_view(head, session.scene_camera, T_world_cam)
        progress("scene", head.index + 1, len(session.scene_t_ns))
    live.finish()
    return live


def _spaced(frames: Iterator[Frame], *, period_s: float) -> Iterator[Frame]:
    last_ns: int | None = None
    for frame in frames:
        if last_ns is None or frame.t_ns - last_ns >= period_s * 1e9:
            last_ns = frame.t_ns
            yield frame
