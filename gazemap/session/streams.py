"""The csv streams of a Neon export: gaze, fixations, blinks, events, inertial samples."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from gazemap.errors import InputError
from gazemap.geometry.arrays import BoolArray, FloatArray, IntArray
from gazemap.session.table import Table, read_table, times_ns
from gazemap.types.session import Blink, Event, Fixation, GazeSamples, ImuSamples

STANDARD_GRAVITY_M_S2 = 9.80665
Warn = Callable[[str], None]


def read_gaze(path: Path, *, warn: Warn) -> GazeSamples:
    """Read gaze.csv; samples without a pixel are kept as NaN, repeated times count once.

    Raises:
        InputError: if a field is wrong or the times run backwards.
    """
    table = read_table(path)
    t_ns, keep = _kept_times(table, warn=warn)
    uv_px = np.column_stack([table.floats("gaze x [px]"), table.floats("gaze y [px]")])
    worn = table.flags("worn") if table.has("worn") else np.ones(len(table), dtype=np.bool_)
    missing = int(np.isnan(uv_px[keep]).any(axis=1).sum())
    if missing:
        warn(f"{path.name}: {missing} of {int(keep.sum())} samples have no gaze point")
    return GazeSamples(
        t_ns=t_ns[keep], uv_px=uv_px[keep], worn=worn[keep], blink=_blinks(table)[keep]
    )


def read_fixations(path: Path, *, warn: Warn) -> tuple[Fixation, ...]:
    """Read fixations.csv; fixations without a pixel are left out with a warning."""
    table = read_table(path)
    spans = _intervals(table)
    ids = table.ints("fixation id")
    u_px, v_px = table.floats("fixation x [px]"), table.floats("fixation y [px]")
    known = np.isfinite(u_px) & np.isfinite(v_px)
    if not known.all():
        warn(f"{path.name}: {int((~known).sum())} fixations without a point were left out")
    _unique(ids, table=table)
    return tuple(
        Fixation(
            fixation_id=int(ids[i]),
            start_ns=spans[i][0],
            end_ns=spans[i][1],
            u_px=float(u_px[i]),
            v_px=float(v_px[i]),
        )
        for i in np.flatnonzero(known)
    )


def read_blinks(path: Path) -> tuple[Blink, ...]:
    """Read blinks.csv."""
    return tuple(Blink(start_ns=a, end_ns=b) for a, b in _intervals(read_table(path)))


def read_events(path: Path) -> tuple[Event, ...]:
    """Read events.csv, in the order of the file."""
    table = read_table(path)
    times = table.ints("timestamp [ns]").tolist()
    return tuple(
        Event(t_ns=t_ns, name=name) for t_ns, name in zip(times, table.texts("name"), strict=True)
    )


def read_imu(path: Path, *, warn: Warn) -> ImuSamples:
    """Read imu.csv, which counts in degrees per second and in g."""
    table = read_table(path)
    t_ns, keep = _kept_times(table, warn=warn)
    gyro_deg_s = _axes(table, "gyro {} [deg/s]")
    accel_g = _axes(table, "acceleration {} [g]")
    known = keep & np.isfinite(gyro_deg_s).all(axis=1) & np.isfinite(accel_g).all(axis=1)
    if known.sum() < keep.sum():
        warn(f"{path.name}: {int(keep.sum() - known.sum())} samples with gaps were left out")
    return ImuSamples(
        t_ns=t_ns[known],
        gyro_rad_s=np.radians(gyro_deg_s[known]),
        accel_m_s2=accel_g[known] * STANDARD_GRAVITY_M_S2,
    )


def _kept_times(table: Table, *, warn: Warn) -> tuple[IntArray, BoolArray]:
    t_ns, keep = times_ns(table, "timestamp [ns]")
    if not keep.all():
        warn(f"{table.path.name}: {int((~keep).sum())} rows repeat a time and were left out")
    if not len(table):
        warn(f"{table.path.name}: no row in it")
    return t_ns, keep


def _blinks(table: Table) -> BoolArray:
    if not table.has("blink id"):
        return np.zeros(len(table), dtype=np.bool_)
    return np.array([bool(text) for text in table.texts("blink id")], dtype=np.bool_)


def _axes(table: Table, pattern: str) -> FloatArray:
    # Older exports write [G].
    unit_free = {name.lower(): name for name in table.columns}
    names = [pattern.format(axis) for axis in "xyz"]
    return np.column_stack([table.floats(unit_free.get(name, name)) for name in names])


def _intervals(table: Table) -> list[tuple[int, int]]:
    """Return start and end of each row, which follow one another in time."""
    starts, _ = times_ns(table, "start timestamp [ns]")
    ends = table.ints("end timestamp [ns]")
    backwards = np.flatnonzero(ends < starts)
    if len(backwards):
        raise table.wrong_field(
            int(backwards[0]), name="end timestamp [ns]", wanted="a time after the start"
        )
    return list(zip(starts.tolist(), ends.tolist(), strict=True))


def _unique(ids: IntArray, *, table: Table) -> None:
    seen: set[int] = set()
    for row, each in enumerate(ids.tolist()):
        if each in seen:
            raise table.wrong_field(row, name="fixation id", wanted="an id that was not used yet")
        seen.add(each)


def check_overlap(gaze: GazeSamples, *, scene_t_ns: tuple[int, ...], path: Path) -> None:
    """Raise InputError if gaze and video were not recorded at the same time."""
    if len(gaze.t_ns) and (gaze.t_ns[-1] < scene_t_ns[0] or gaze.t_ns[0] > scene_t_ns[-1]):
        raise InputError(
            f"gaze from {gaze.t_ns[0]} to {gaze.t_ns[-1]} lies outside the video, "
            f"{scene_t_ns[0]} to {scene_t_ns[-1]}",
            where=path,
            todo="give gaze and video of one recording, on one clock",
        )
