"""The eye tracker's own camera, where a rig tracks with another one.

`info.json` may hold `gaze_camera`: what a camera file holds with the size of its images, and
`T_scene_gaze`, 4x4, which maps points of its optical frame into that of the scene camera. The
pixels of gaze and fixations are then on its images.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gazemap.errors import ConventionError, InputError
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, GazeCam, Pose
from gazemap.session.camera_file import camera_in
from gazemap.session.documents import numbers
from gazemap.types.session import SessionData

_WHERE = "info.json: gaze_camera"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GazeCamera:
    """The camera on whose images gaze is given, and how it sits beside the scene camera."""

    camera: Camera
    T_cam_gaze: Pose[Cam, GazeCam]


def gaze_camera_of(data: SessionData) -> GazeCamera | None:
    """Return the eye tracker's own camera of a session, as `gaze_camera_in` does."""
    return gaze_camera_in(data.info)


def gaze_camera_in(info: Mapping[str, object]) -> GazeCamera | None:
    """Return the eye tracker's own camera; None where gaze is on the scene camera's images.

    Raises:
        InputError: if what `info.json` says of it is wrong.
    """
    described: Any = info.get("gaze_camera")
    if described is None:
        return None
    if not isinstance(described, dict):
        raise InputError("an object is expected", where=_WHERE, todo="correct it")
    matrix = numbers(described, "T_scene_gaze", path=_WHERE)
    if matrix.size != 16 or not np.allclose(matrix[12:], [0, 0, 0, 1]):
        raise InputError(
            "'T_scene_gaze' must be 4x4 with a last row of 0 0 0 1",
            where=_WHERE,
            todo="correct it",
        )
    T = matrix.reshape(4, 4)
    try:
        T_cam_gaze = Pose[Cam, GazeCam](R=T[:3, :3], t=T[:3, 3])
    except ConventionError as error:
        raise InputError(f"'T_scene_gaze': {error}", where=_WHERE, todo="correct it") from error
    return GazeCamera(camera=camera_in(described, where=_WHERE), T_cam_gaze=T_cam_gaze)
