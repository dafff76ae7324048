"""How fast recordings are read and written, and messages encoded, beside the libraries alone."""

import json
import tempfile
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Final

import av
import numpy as np

from gazemap.geometry.camera import Camera
from gazemap.session.mcap_session import open_mcap
from gazemap.session.mcap_write import write_mcap
from gazemap.session.recorded import RecordedSession
from gazemap.session.video import VideoFile
from gazemap.types.session import GazeSample, SessionData
from gazemap.types.tracking import Scale
from gazemap.wire import rig, surface
from services.bench.figures import Figure, median_ms

_FRAME_COUNT: Final = 120
_STEP_NS: Final = 33_333_333
_POINT_COUNT: Final = 20_000
_REPEATS: Final = 5


def run(*, repeats: int = _REPEATS) -> list[Figure]:
    """Return the CPU time of reading, writing and encoding."""
    with tempfile.TemporaryDirectory() as folder:
        recording = _of_frames(_recording(Path(folder)), Path(folder), repeats=repeats)
    return [*recording, *_of_messages(repeats=repeats)]


def _of_frames(session: RecordedSession, folder: Path, *, repeats: int) -> list[Figure]:
    video, native = folder / "scene.mp4", folder / "scene.mcap"
    write_mcap(session, native)
    bare = median_ms(lambda: _decode_alone(video), repeats=repeats) / _FRAME_COUNT

    def figure(name: str, work: Callable[[], object]) -> Figure:
        return Figure(
            name=name,
            value=median_ms(work, repeats=repeats) / _FRAME_COUNT,
            unit="ms a frame",
            peer="PyAV alone",
            peer_value=bare,
        )

    opened = open_mcap(native, camera=None)
    return [
        figure("read a video", lambda: list(map(_touch, session.scene_frames()))),
        figure("read an MCAP file", lambda: list(map(_touch, opened.scene_frames()))),
        figure("open an MCAP file", lambda: open_mcap(native, camera=None)),
        figure("write an MCAP file", lambda: write_mcap(session, native)),
    ]


def _of_messages(*, repeats: int) -> list[Figure]:
    sample = GazeSample(t_ns=1_760_000_000_000_000_000, u_px=1.5, v_px=2.5, worn=True, blink=False)
    coded, count = rig.encode_gaze(sample), 2000
    text = json.dumps(asdict(sample))
    rng = np.random.default_rng(1)
    points = surface.MapPoints(
        t_ns=0,
        points_world=rng.normal(size=(_POINT_COUNT, 3)),
        colours=rng.integers(0, 256, size=(_POINT_COUNT, 3), dtype=np.uint8),
        scale=Scale.METRIC,
    )

    def each_us(work: Callable[[], object]) -> float:
        return median_ms(lambda: [work() for _ in range(count)], repeats=repeats) / count * 1e3

    return [
        Figure(
            name="encode a gaze sample",
            value=each_us(lambda: rig.encode_gaze(sample)),
            unit="us",
            peer="json",
            peer_value=each_us(lambda: json.dumps(asdict(sample))),
        ),
        Figure(
            name="decode a gaze sample",
            value=each_us(lambda: rig.decode_gaze(coded)),
            unit="us",
            peer="json",
            peer_value=each_us(lambda: GazeSample(**json.loads(text))),
        ),
        Figure(
            name=f"encode {_POINT_COUNT} points",
            value=median_ms(lambda: surface.encode_points(points), repeats=repeats),
            unit="ms",
            peer="json",
            peer_value=median_ms(lambda: json.dumps(points.points_world.tolist()), repeats=repeats),
        ),
    ]


def _touch(frame: object) -> None:
    """Let a frame go at once, as a reader of a long recording does."""


def _decode_alone(path: Path) -> None:
    with av.open(path) as container:
        container.streams.video[0].thread_type = "AUTO"
        for picture in container.decode(video=0):
            picture.to_ndarray(format="bgr24")


def _recording(folder: Path) -> RecordedSession:
    """Write a video of a drifting texture."""
    camera = Camera(
        width_px=800,
        height_px=600,
        K=np.array([[560.0, 0, 400], [0, 560, 300], [0, 0, 1]]),
        distortion=np.zeros(4),
    )
    texture = np.random.default_rng(7).integers(0, 256, size=(80, 120, 3), dtype=np.uint8)
    large = texture.repeat(10, axis=0).repeat(10, axis=1)
    path = folder / "scene.mp4"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30, options={"preset": "veryfast"})
        stream.width, stream.height, stream.pix_fmt = 800, 600, "yuv420p"
        for i in range(_FRAME_COUNT):
            view = np.ascontiguousarray(large[i : i + 600, i : i + 800])
            container.mux(stream.encode(av.VideoFrame.from_ndarray(view, format="bgr24")))
        container.mux(stream.encode())
    t_ns = tuple(i * _STEP_NS for i in range(_FRAME_COUNT))
    return RecordedSession(
        data=SessionData(name="bench"), scene=VideoFile(camera=camera, t_ns=t_ns, path=path)
    )
