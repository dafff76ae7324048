"""The sparse map as a COLMAP model, which pycolmap and COLMAP open.

COLMAP's pixel (0.5, 0.5) is the centre of the top-left pixel: half a pixel is added here.
"""

from pathlib import Path
from typing import Final

import numpy as np

from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.camera import Camera, LensModel
from gazemap.session.atomic import whole_folder
from gazemap.types.slam import SlamResult

_HALF_PIXEL: Final = 0.5
_FULL_OPENCV_COUNT: Final = 8


def write_colmap(result: SlamResult, folder: Path) -> None:
    """Write cameras, images, points (binary) to a folder, which is whole or not there.

    The images are the keyframes, named by their time in nanoseconds. A lens that COLMAP has no
    model for is written as a pinhole with the views undistorted.
    """
    import pycolmap

    model, parameters = colmap_camera(result.camera)
    rec = pycolmap.Reconstruction()
    rec.add_camera_with_trivial_rig(
        pycolmap.Camera(
            model=model, width=result.camera.width_px, height=result.camera.height_px,
            params=parameters, camera_id=1,
        )
    )  # fmt: skip
    uv_px = _pixels(result, model=model)
    row_of = {int(t): i for i, t in enumerate(result.trajectory.t_ns)}
    start = np.searchsorted(result.map.view_keyframe, np.arange(len(result.map.keyframe_t_ns) + 1))
    tracks = [pycolmap.Track() for _ in result.map.points_world]
    for k, t_ns in enumerate(result.map.keyframe_t_ns.tolist()):
        mine = slice(int(start[k]), int(start[k + 1]))
        T_cam_world = result.trajectory.pose(row_of[t_ns]).inverse()
        image = pycolmap.Image(
            name=f"{t_ns}", keypoints=uv_px[mine] + _HALF_PIXEL, camera_id=1, image_id=k + 1
        )
        rec.add_image_with_trivial_frame(
            image, pycolmap.Rigid3d(np.column_stack([T_cam_world.R, T_cam_world.t]))
        )
        for feature, j in enumerate(result.map.view_point[mine].tolist()):
            tracks[j].add_element(k + 1, feature)
    for track, xyz, colour in zip(tracks, result.map.points_world, result.map.colours, strict=True):
        if track.length() >= 2:
            rec.add_point3D(xyz, track, colour)
    rec.update_point_3d_errors()
    with whole_folder(folder) as partial:
        rec.write_binary(str(partial))


def colmap_camera(camera: Camera) -> tuple[str, list[float]]:
    """Return COLMAP's name of a camera's model and its parameters; PINHOLE where it has none."""
    K, distortion = camera.K, camera.distortion.tolist()
    pinhole = [K[0, 0], K[1, 1], K[0, 2] + _HALF_PIXEL, K[1, 2] + _HALF_PIXEL]
    if camera.lens is LensModel.FISHEYE:
        return "OPENCV_FISHEYE", [*pinhole, *distortion]
    if not any(distortion[_FULL_OPENCV_COUNT:]) and K[0, 1] == 0 and distortion:
        padded = [*distortion[:_FULL_OPENCV_COUNT], *[0.0] * _FULL_OPENCV_COUNT]
        return "FULL_OPENCV", [*pinhole, *padded[:_FULL_OPENCV_COUNT]]
    return "PINHOLE", pinhole


def _pixels(result: SlamResult, *, model: str) -> FloatArray:
    """Return the views as the model's camera would have recorded them (V, 2)."""
    if model != "PINHOLE":
        return result.map.view_uv_px
    flat = result.camera.normalize(result.map.view_uv_px)
    K = result.camera.K
    pixels: FloatArray = flat * [K[0, 0], K[1, 1]] + [K[0, 2], K[1, 2]]
    return pixels
