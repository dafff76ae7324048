"""EuRoC folders: `cam0/data.csv` and `cam0/sensor.yaml`, with `imu0` where there is one."""

from pathlib import Path

import numpy as np

from gazemap.errors import ConventionError, InputError
from gazemap.geometry.camera import Camera, LensModel
from gazemap.session.camera_file import ImageSize, check_size, read_camera
from gazemap.session.documents import numbers, read_yaml
from gazemap.session.frames import ImageFiles, image_size, read_image
from gazemap.session.recorded import RecordedSession
from gazemap.session.table import read_table
from gazemap.session.video import frame_times
from gazemap.types.session import ImuSamples, SessionData

_LENSES = {
    "radial-tangential": LensModel.PINHOLE,
    "radtan": LensModel.PINHOLE,
    "equidistant": LensModel.FISHEYE,
    "equi": LensModel.FISHEYE,
}


def find_sensor(path: Path) -> Path | None:
    """Return the folder of the first camera, given it or one above it."""
    for folder in (path, path / "cam0", path / "mav0" / "cam0"):
        if (folder / "sensor.yaml").is_file() and (folder / "data.csv").is_file():
            return folder
    return None


def open_euroc(path: Path, *, camera: Path | None) -> RecordedSession:
    """Open a EuRoC folder: its own, its `mav0` or its `cam0`."""
    sensor = find_sensor(path)
    if sensor is None:
        raise InputError(
            "no cam0/sensor.yaml with data.csv", where=path, todo="give a EuRoC folder"
        )
    t_ns, paths = _images(sensor)
    size = image_size(read_image(paths[0]))
    return RecordedSession(
        data=SessionData(name=path.resolve().name, imu=_read_imu(sensor.parent / "imu0")),
        scene=ImageFiles(
            camera=read_camera(camera, size=size)
            if camera
            else _read_sensor(sensor / "sensor.yaml", size=size),
            t_ns=t_ns,
            paths=paths,
        ),
    )


def _images(sensor: Path) -> tuple[tuple[int, ...], tuple[Path, ...]]:
    listing = sensor / "data.csv"
    t_ns = frame_times(listing)
    table = read_table(listing)
    paths = tuple(sensor / "data" / name for name in table.texts("filename"))
    for line, image in zip(table.lines, paths, strict=True):
        if not image.is_file():
            raise InputError(
                f"the image {image.name} is missing", where=f"{listing}, line {line}", todo="add it"
            )
    return t_ns, paths


def _read_sensor(path: Path, *, size: ImageSize) -> Camera:
    document = read_yaml(path)
    intrinsics = numbers(document, "intrinsics", path=path)
    if intrinsics.size != 4:
        raise InputError("'intrinsics' must be fu, fv, cu, cv", where=path, todo="correct it")
    name = str(document.get("distortion_model"))
    if name not in _LENSES:
        raise InputError(
            f"'distortion_model' is '{name}'; known: {', '.join(_LENSES)}",
            where=path,
            todo="correct it",
        )
    fu, fv, cu, cv = intrinsics
    try:
        camera = Camera(
            width_px=size.width_px,
            height_px=size.height_px,
            K=np.array([[fu, 0, cu], [0, fv, cv], [0, 0, 1]]),
            distortion=numbers(document, "distortion_coefficients", path=path),
            lens=_LENSES[name],
        )
    except ConventionError as error:
        raise InputError(str(error), where=path, todo="correct the file") from error
    check_size(camera, stated=_resolution(document.get("resolution")), path=path)
    return camera


def _resolution(value: object) -> ImageSize | None:
    if not isinstance(value, list) or len(value) != 2:
        return None
    return ImageSize(width_px=int(value[0]), height_px=int(value[1]))


def _read_imu(folder: Path) -> ImuSamples | None:
    if not (folder / "data.csv").is_file():
        return None
    table = read_table(folder / "data.csv")
    gyro = [table.floats(f"w_RS_S_{axis} [rad s^-1]") for axis in "xyz"]
    accel = [table.floats(f"a_RS_S_{axis} [m s^-2]") for axis in "xyz"]
    return ImuSamples(
        t_ns=np.array(frame_times(folder / "data.csv"), dtype=np.int64),
        gyro_rad_s=np.column_stack(gyro),
        accel_m_s2=np.column_stack(accel),
    )
