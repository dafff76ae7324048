"""Recordings as Pupil Labs Neon's phone writes them, before any export."""

import struct
from pathlib import Path
from typing import Final

import numpy as np

from gazemap.errors import ConventionError, InputError
from gazemap.geometry.arrays import BoolArray, FloatArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.session.camera_file import ImageSize, read_camera
from gazemap.session.documents import read_json
from gazemap.session.folder import heading_rad
from gazemap.session.frames import FrameSource, JoinedFrames, MissingFrames
from gazemap.session.neon_parts import (
    RawPart,
    damaged,
    imu_packets,
    new_times,
    part_files,
    parts,
    read_times,
)
from gazemap.session.recorded import RecordedSession
from gazemap.session.streams import STANDARD_GRAVITY_M_S2
from gazemap.session.video import VideoFile, checked_video
from gazemap.types.session import Blink, Event, Fixation, GazeSamples, ImuSamples, SessionData

_SCENE: Final = "Neon Scene Camera v1"
_SIZE: Final = ImageSize(width_px=1600, height_px=1200)
# Version, serial number, camera matrix, distortion; the eye cameras follow.
_CALIBRATION: Final = struct.Struct("<B6s9d8d")
_GAZE: Final = np.dtype([("x", "<f4"), ("y", "<f4")])
_FIXATION: Final = 1


def is_neon_native(path: Path) -> bool:
    """Tell whether a folder is a recording of a Neon phone."""
    return any(path.glob(f"{_SCENE} ps*.time")) or any(path.glob("gaze ps*.raw"))


def open_neon_native(path: Path, *, camera: Path | None) -> RecordedSession:
    """Open a Neon phone's recording; one without its video has no frames.

    Args:
        path: the folder.
        camera: a camera file to use in place of calibration.bin.
    """
    warnings: list[str] = []
    scene = _scene(path, camera=_camera(path, camera=camera))
    if isinstance(scene, MissingFrames):
        warnings.append(f"{path.name}: the recording has no scene video")
    blinks = _blinks(path)
    info = read_json(path / "info.json") if (path / "info.json").is_file() else {}
    return RecordedSession(
        data=SessionData(
            name=path.resolve().name,
            gaze=_gaze(path, blinks=blinks),
            fixations=_fixations(path),
            blinks=blinks,
            events=_events(path),
            imu=_imu(path),
            wearer_heading_rad=heading_rad(info, path / "info.json"),
            info=info,
            warnings=tuple(warnings),
        ),
        scene=scene,
    )


def _camera(path: Path, *, camera: Path | None) -> Camera:
    if camera is not None:
        return read_camera(camera, size=_SIZE)
    file = path / "calibration.bin"
    try:
        _, serial, *numbers = _CALIBRATION.unpack_from(file.read_bytes())
        return Camera(
            width_px=_SIZE.width_px,
            height_px=_SIZE.height_px,
            K=np.reshape(numbers[:9], (3, 3)),
            distortion=np.array(numbers[9:]),
            serial=serial.decode("ascii"),
        )
    except (OSError, struct.error, ConventionError, UnicodeDecodeError) as error:
        raise InputError(
            "the calibration is missing or damaged", where=file, todo="copy it, or give --camera"
        ) from error


def _scene(path: Path, *, camera: Camera) -> FrameSource:
    videos: list[VideoFile] = []
    for times in part_files(path, _SCENE, suffix=".time"):
        video = times.with_suffix(".mp4")
        if video.is_file():
            t_ns = tuple(read_times(times).tolist())
            videos.append(checked_video(video, t_ns=t_ns, camera=camera, timestamps=times))
    if not videos:
        return MissingFrames(camera=camera, path=path)
    return videos[0] if len(videos) == 1 else JoinedFrames(parts=tuple(videos))


def _gaze(path: Path, *, blinks: tuple[Blink, ...]) -> GazeSamples | None:
    """Return the gaze; what was sampled up after the recording, in one part, is preferred."""
    whole = path / "gaze_200hz.raw"
    found = (
        [RawPart(raw=whole, fields=_GAZE)] if whole.is_file() else parts(path, "gaze", fields=_GAZE)
    )
    if not found:
        return None
    rows = np.concatenate([part.rows() for part in found])
    t_ns = np.concatenate([part.t_ns() for part in found])
    worn = np.concatenate([_worn(part) for part in found])
    blink = np.zeros(len(t_ns), dtype=np.bool_)
    for each in blinks:
        blink |= (t_ns >= each.start_ns) & (t_ns <= each.end_ns)
    keep = new_times(t_ns, where=found[0].raw)
    uv_px = np.column_stack([rows["x"], rows["y"]]).astype(np.float64)
    return GazeSamples(t_ns=t_ns[keep], uv_px=uv_px[keep], worn=worn[keep], blink=blink[keep])


def _worn(gaze: RawPart) -> BoolArray:
    """Return whether the glasses were worn at each sample; some files end in a further byte."""
    path, count = gaze.raw.with_name(gaze.raw.name.replace("gaze", "worn")), len(gaze.rows())
    if not path.is_file():
        return np.ones(count, dtype=np.bool_)
    flags = np.fromfile(path, dtype=np.uint8)[:count]
    if len(flags) < count:
        raise damaged(path, f"{len(flags)} values for {count} samples")
    return flags > 0


def _fixations(path: Path) -> tuple[Fixation, ...] | None:
    found = parts(path, "fixations")
    if not found:
        return None
    rows = [row for part in found for row in part.rows() if row["event_type"] == _FIXATION]
    return tuple(
        Fixation(
            fixation_id=number,
            start_ns=int(row["start_timestamp_ns"]),
            end_ns=int(row["end_timestamp_ns"]),
            u_px=float(row["mean_gaze_x"]),
            v_px=float(row["mean_gaze_y"]),
        )
        for number, row in enumerate(rows, start=1)
    )


def _blinks(path: Path) -> tuple[Blink, ...]:
    return tuple(
        Blink(start_ns=int(row["start_timestamp_ns"]), end_ns=int(row["end_timestamp_ns"]))
        for part in parts(path, "blinks")
        for row in part.rows()
    )


def _events(path: Path) -> tuple[Event, ...]:
    names, times = path / "event.txt", path / "event.time"
    if not names.is_file() or not times.is_file():
        return ()
    pairs = zip(read_times(times).tolist(), names.read_text().splitlines(), strict=False)
    return tuple(Event(t_ns=t_ns, name=name) for t_ns, name in pairs)


def _imu(path: Path) -> ImuSamples | None:
    newer, older = parts(path, "imu"), part_files(path, "extimu", suffix=".raw")
    if newer:
        rows = np.concatenate([part.rows() for part in newer])
        t_ns = np.concatenate([part.t_ns() for part in newer])
        gyro_deg_s = np.column_stack([rows[f"gyro_{axis}"] for axis in "xyz"])
        accel_g = np.column_stack([rows[f"accel_{axis}"] for axis in "xyz"])
        return _imu_samples(t_ns, gyro_deg_s, accel_g=accel_g, where=newer[0].raw)
    if older:
        packets = [packet for part in older for packet in imu_packets(part)]
        t_ns = np.concatenate([read_times(part.with_suffix(".time")) for part in older])
        if len(t_ns) != len(packets):
            raise damaged(older[0], f"{len(packets)} samples for {len(t_ns)} times")
        gyros, accels = [p.gyro_deg_s for p in packets], [p.accel_g for p in packets]
        gyro_deg_s = np.array([(g.x, g.y, g.z) for g in gyros])
        accel_g = np.array([(a.x, a.y, a.z) for a in accels])
        return _imu_samples(t_ns, gyro_deg_s, accel_g=accel_g, where=older[0])
    return None


def _imu_samples(
    t_ns: IntArray, gyro_deg_s: FloatArray, *, accel_g: FloatArray, where: Path
) -> ImuSamples:
    keep = new_times(t_ns, where=where)
    return ImuSamples(
        t_ns=t_ns[keep],
        gyro_rad_s=np.radians(gyro_deg_s[keep].astype(np.float64)),
        accel_m_s2=accel_g[keep].astype(np.float64) * STANDARD_GRAVITY_M_S2,
    )
