"""Trajectories as TUM files: a row `timestamp[s] tx ty tz qx qy qz qw` for each `T_world_cam`."""

import json
from decimal import Decimal, InvalidOperation
from pathlib import Path

import numpy as np

from gazemap.errors import InputError
from gazemap.session.atomic import whole_file
from gazemap.types.tracking import Scale, Trajectory


def write_tum(trajectory: Trajectory, path: Path) -> None:
    """Write the poses to FILE.tum, and FILE.json beside it with the frame, scale and map id."""
    with whole_file(path) as partial:
        partial.write_text("".join(f"{line}\n" for line in _rows(trajectory)))
    facts = {"frame": "world", "scale": trajectory.scale.value, "map_id": trajectory.map_id}
    with whole_file(path.with_suffix(".json")) as partial:
        partial.write_text(json.dumps(facts) + "\n")


def _rows(trajectory: Trajectory) -> list[str]:
    rows = []
    for i, t_ns in enumerate(trajectory.t_ns.tolist()):
        numbers = [*trajectory.p_world_cam[i], *trajectory.quat_xyzw[i]]
        # Whole seconds and nanoseconds apart: float64 seconds since 1970 cannot hold nanoseconds.
        stamp = f"{t_ns // 1_000_000_000}.{t_ns % 1_000_000_000:09d}"
        rows.append(" ".join([stamp, *(f"{x:.9f}" for x in numbers)]))
    return rows


def read_tum(path: Path) -> Trajectory:
    """Read a file that `write_tum` or another program wrote; without FILE.json it is arbitrary.

    Raises:
        InputError: if the file is missing or a row is not eight numbers.
    """
    try:
        lines = path.read_text().splitlines()
    except OSError as error:
        raise InputError(
            f"cannot be read ({error.strerror})", where=path, todo="check it"
        ) from error
    rows = [(n, line.split()) for n, line in enumerate(lines, 1) if line and line[0] != "#"]
    t_ns, numbers = [], []
    for n, row in rows:
        try:
            t_ns.append(int(Decimal(row[0]) * 1_000_000_000))
            numbers.append([float(x) for x in row[1:8]])
        except (InvalidOperation, ValueError, IndexError) as error:
            todo = "write `timestamp tx ty tz qx qy qz qw`"
            raise InputError("eight numbers expected", where=f"{path}:{n}", todo=todo) from error
    table = np.array(numbers, dtype=np.float64).reshape(-1, 7)
    scale, map_id = _facts(path)
    return Trajectory(
        t_ns=np.array(t_ns, dtype=np.int64),
        quat_xyzw=table[:, 3:],
        p_world_cam=table[:, :3],
        scale=scale,
        map_id=map_id,
    )


def _facts(path: Path) -> tuple[Scale, int]:
    beside = path.with_suffix(".json")
    if not beside.exists():
        return Scale.ARBITRARY, 0
    facts = json.loads(beside.read_text())
    return Scale(facts["scale"]), int(facts["map_id"])
