"""Tracking and mapping beside pycolmap's pipelines on the same keyframes of a simulated session."""

import resource
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from gazemap.geometry.align import Similarity, fit_similarity
from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.pose import World
from gazemap.ports import Session
from gazemap.session.opening import open_session
from gazemap.session.tum_file import read_tum
from gazemap.sim.config import Level, preset, resized
from gazemap.sim.simulate import simulate
from gazemap.slam.colmap import colmap_camera
from gazemap.slam.config import SlamConfig
from gazemap.slam.offline import map_session
from gazemap.slam.tag_alignment import Map
from gazemap.types.slam import SlamResult
from gazemap.types.tracking import Tracked, Trajectory
from services.bench.figures import Figure

_SECONDS: Final = 6.0
_FEWEST_TO_ALIGN: Final = 4
_PEERS: Final = ("incremental", "global")


@dataclass(frozen=True, slots=True, kw_only=True)
class _Run:
    """CPU seconds, camera centres (N, 3) by time in ns."""

    cpu_s: float
    centres: dict[int, FloatArray]


def run(*, seconds: float = _SECONDS) -> list[Figure]:
    """Return time and error of offline mapping and of live tracking."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _simulate(folder, seconds=seconds)
        session, truth = open_session(folder / "session"), read_tum(folder / "truth/trajectory.tum")
        map_session(session, SlamConfig())  # compiles what is compiled
        result, cpu_s = _timed(lambda: map_session(session, SlamConfig()))
        rss_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        ours = _Run(cpu_s=cpu_s, centres=_centres(result.trajectory))
        _write_keyframes(session, result, folder / "keyframes")
        figures = [Figure(name="peak memory, offline", value=rss_mb, unit="MB")]
        for peer in _PEERS:
            theirs = _colmap(result, folder, pipeline=peer)
            figures += _beside(
                ours, theirs, truth, peer=f"pycolmap {peer}",
                keyframe_count=len(result.map.keyframe_t_ns),
            )  # fmt: skip
        return figures + _live(session, truth)


def _simulate(folder: Path, *, seconds: float) -> None:
    config = replace(preset(Level.EASY), seconds=seconds)
    lens = resized(config.scene_lens, width_px=640, height_px=480, rate_hz=30.0)
    config = replace(config, scene_lens=lens, has_overhead=False)
    simulate(config, folder, progress=lambda *_: None)


def _timed(work: Callable[[], SlamResult]) -> tuple[SlamResult, float]:
    start = time.process_time()
    result = work()
    return result, time.process_time() - start


def _centres(trajectory: Trajectory) -> dict[int, FloatArray]:
    return dict(zip(trajectory.t_ns.tolist(), trajectory.p_world_cam, strict=True))


def _write_keyframes(session: Session, result: SlamResult, folder: Path) -> None:
    folder.mkdir()
    wanted = set(result.map.keyframe_t_ns.tolist())
    for frame in session.scene_frames():
        if frame.t_ns in wanted:
            cv2.imwrite(str(folder / f"{frame.t_ns}.png"), frame.image)


def _colmap(result: SlamResult, folder: Path, *, pipeline: str) -> _Run:
    """Extract, match and map the keyframes with the known camera."""
    import pycolmap

    database, images = folder / f"{pipeline}.db", folder / "keyframes"
    # A pipeline that finds no model says so on stderr; here that is a figure.
    pycolmap.logging.minloglevel = pycolmap.logging.FATAL.value
    model, parameters = colmap_camera(result.camera)
    reader = pycolmap.ImageReaderOptions()
    reader.camera_model = model
    reader.camera_params = ",".join(repr(float(x)) for x in parameters)
    start = time.process_time()
    pycolmap.extract_features(
        database, images, camera_mode=pycolmap.CameraMode.SINGLE, reader_options=reader
    )
    pycolmap.match_exhaustive(database)
    mapping = pycolmap.incremental_mapping if pipeline == "incremental" else pycolmap.global_mapping
    models = mapping(database, images, folder / pipeline)
    cpu_s = time.process_time() - start
    largest = max(models.values(), key=lambda rec: int(rec.num_reg_images()), default=None)
    posed = [] if largest is None else [i for i in largest.images.values() if i.has_pose]
    centres = {int(Path(i.name).stem): np.asarray(i.projection_center()) for i in posed}
    return _Run(cpu_s=cpu_s, centres=centres)


def _beside(
    ours: _Run, theirs: _Run, truth: Trajectory, *, peer: str, keyframe_count: int
) -> list[Figure]:
    """Compare on the keyframes that the peer posed; its time is for keyframes alone."""
    shared = {t: ours.centres[t] for t in theirs.centres}
    figures = [
        Figure(
            name="whole recording, CPU", value=ours.cpu_s, unit="s",
            peer=f"{peer}, keyframes alone", peer_value=theirs.cpu_s,
        ),
        Figure(
            name="keyframes posed", value=float(keyframe_count), unit="",
            peer=peer, peer_value=float(len(theirs.centres)),
        ),
    ]  # fmt: skip
    if len(shared) >= _FEWEST_TO_ALIGN:
        figures.append(
            Figure(
                name=f"error on {len(shared)} keyframes", value=_error_mm(shared, truth), unit="mm",
                peer=peer, peer_value=_error_mm(theirs.centres, truth),
            )
        )  # fmt: skip
    return figures


def _error_mm(centres: dict[int, FloatArray], truth: Trajectory) -> float:
    """Return the root mean square error after a similarity; NaN where that is not fixed."""
    times = sorted(centres)
    rows = np.searchsorted(truth.t_ns, times)
    true = truth.p_world_cam[rows]
    found = np.array([centres[t] for t in times]).reshape(-1, 3)
    S_true_found: Similarity[World, Map] | None = fit_similarity(found, true)
    if S_true_found is None:
        return float("nan")
    return float(np.sqrt(((S_true_found.transform(found) - true) ** 2).sum(axis=1).mean()) * 1e3)


def _live(session: Session, truth: Trajectory) -> list[Figure]:
    """Time the tracking thread, frame by frame, while mapping runs beside it."""
    from gazemap.slam.live.tracker import LiveTracker

    frames = list(session.scene_frames())
    times_ms, centres = [], {}
    with LiveTracker(session.scene_camera) as tracker:
        began_s = time.perf_counter()
        for frame in frames:
            start_ns = time.thread_time_ns()
            outcome = tracker.track(frame)
            times_ms.append((time.thread_time_ns() - start_ns) / 1e6)
            if isinstance(outcome, Tracked):
                centres[outcome.t_ns] = outcome.T_world_cam.t
        wall_s = time.perf_counter() - began_s
    median, slowest = np.quantile(times_ms, [0.5, 0.99])
    return [
        Figure(name="live tracking, median frame", value=float(median), unit="ms of CPU"),
        Figure(name="live tracking, p99 frame", value=float(slowest), unit="ms of CPU"),
        Figure(name="live tracking and mapping", value=len(frames) / wall_s, unit="frames/s"),
        Figure(name="live, frames tracked", value=len(centres) / len(frames), unit=""),
        Figure(name="live, error", value=_error_mm(centres, truth), unit="mm"),
    ]
