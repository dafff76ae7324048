"""Maps on disk: one file, versioned, written whole or not at all."""

import json
import zipfile
from pathlib import Path

import numpy as np

from gazemap.errors import InputError
from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.session.atomic import whole_file
from gazemap.slam.live.mapdata import Features, Keyframe, Measurements, SparseMap
from gazemap.types.tracking import Scale

_FORMAT = "gazemap-live-map"
_VERSION = 1


def save_map(sparse: SparseMap, path: Path) -> None:
    """Write a map; corners without a position are left out, and so are the images."""
    f, m = sparse.features, sparse.measurements
    mapped = f.mapped
    used = np.isin(m.feature, f.ids[mapped])
    keyframes = [sparse.keyframes[k] for k in sorted(sparse.keyframes)]
    header = {
        "format": _FORMAT,
        "version": _VERSION,
        "map_id": sparse.map_id,
        "scale": sparse.scale.value,
    }
    with whole_file(path) as partial, partial.open("wb") as file:
        np.savez_compressed(
            file,
            header=np.frombuffer(json.dumps(header).encode(), np.uint8),
            keyframe_ids=np.array([k.keyframe_id for k in keyframes]),
            keyframe_t_ns=np.array([k.t_ns for k in keyframes]),
            keyframe_twist=np.array([k.twist for k in keyframes]),
            T_cam_world=np.array([k.T_cam_world.matrix for k in keyframes]),
            T_cam_world_published=np.array([_matrix(k.T_cam_world_published) for k in keyframes]),
            ids=f.ids[mapped],
            host=f.host[mapped],
            steps=f.steps[mapped],
            references=f.references[mapped],
            points_world=f.points_world[mapped],
            measured_keyframe=m.keyframe[used],
            measured_feature=m.feature[used],
            measured_uv_px=m.uv_px[used],
            measured_xy=m.xy[used],
            measured_sigma_px=m.sigma_px[used],
        )


def load_map(path: Path, camera: Camera) -> SparseMap:
    """Read a map; `camera` may be another than the one that built it.

    Raises:
        InputError: if the file is missing, damaged, or of another version.
    """
    try:
        with np.load(path, allow_pickle=False) as table:
            header = json.loads(bytes(table["header"]).decode())
            _check_header(header, path)
            return _map_of(table, header, camera)
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(
            f"no map that can be read ({error})", where=path, todo="save the map again"
        ) from error


def _check_header(header: dict[str, object], path: Path) -> None:
    if header.get("format") != _FORMAT or header.get("version") != _VERSION:
        raise InputError(
            f"a map of version {_VERSION} expected, got {header.get('format')!r} "
            f"{header.get('version')!r}",
            where=path,
            todo="save the map again with this program",
        )


def _map_of(table: "np.lib.npyio.NpzFile", header: dict[str, object], camera: Camera) -> SparseMap:
    sparse = SparseMap(camera, map_id=int(str(header["map_id"])))
    sparse.scale = Scale(str(header["scale"]))
    for n, keyframe_id in enumerate(table["keyframe_ids"].tolist()):
        sparse.keyframes[keyframe_id] = Keyframe(
            keyframe_id=keyframe_id,
            t_ns=int(table["keyframe_t_ns"][n]),
            pyramid=None,
            T_cam_world=_pose(table["T_cam_world"][n]),
            T_cam_world_published=_published(table["T_cam_world_published"][n]),
            twist=table["keyframe_twist"][n],
        )
    sparse.features = Features(
        ids=table["ids"],
        host=table["host"],
        steps=table["steps"],
        references=table["references"],
        points_world=table["points_world"],
    )
    sparse.measurements = Measurements(
        keyframe=table["measured_keyframe"],
        feature=table["measured_feature"],
        uv_px=table["measured_uv_px"],
        xy=table["measured_xy"],
        sigma_px=table["measured_sigma_px"],
    )
    return sparse


def _pose(matrix: FloatArray) -> Pose[Cam, World]:
    return Pose.from_matrix(matrix)


def _matrix(pose: Pose[Cam, World] | None) -> FloatArray:
    """Return the pose's matrix, NaN for none."""
    return np.full((4, 4), np.nan) if pose is None else pose.matrix


def _published(matrix: FloatArray) -> Pose[Cam, World] | None:
    return None if np.isnan(matrix).any() else _pose(matrix)
