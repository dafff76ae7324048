"""Writes the session folder as a head-worn eye tracker and a fixed camera would have."""

import csv
import io
import json
import uuid
from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Final, Self

import av
import cv2
import numpy as np

from gazemap.geometry.arrays import FloatArray, ImageArray
from gazemap.geometry.camera import Camera, LensModel
from gazemap.sim.config import LensConfig, SimConfig
from gazemap.sim.eyes import Look
from gazemap.sim.eyetracker import EyeRecord
from gazemap.sim.speech import Utterance
from gazemap.sim.textures import TAG_FAMILY, TAG_PLACES_WORLD, TAG_SIZE_M

START_NS: Final = 1_760_000_000_000_000_000
_VIDEO_CLOCK_HZ: Final = 90_000
_HEAD: Final = ("section id", "recording id")


def to_ns(t_s: float) -> int:
    """Return seconds from the first frame as int64 nanoseconds since 1970."""
    return START_NS + round(t_s * 1e9)


def frame_times_s(lens: LensConfig, seconds: float) -> FloatArray:
    """Return when a camera takes its frames."""
    return np.arange(int(seconds * lens.rate_hz)) / lens.rate_hz


class VideoWriter:
    """An H.264 file whose frames carry their own times."""

    def __init__(self, path: Path, lens: LensConfig, *, crf: int) -> None:
        """Open the file; one thread and fixed settings, so that equal frames give equal bytes."""
        self._container = av.open(str(path), "w")
        rate = Fraction(lens.rate_hz).limit_denominator(1000)
        self._stream = self._container.add_stream("libx264", rate=rate)
        self._stream.width, self._stream.height = lens.width_px, lens.height_px
        self._stream.pix_fmt = "yuv420p"
        self._stream.time_base = Fraction(1, _VIDEO_CLOCK_HZ)
        self._stream.codec_context.time_base = Fraction(1, _VIDEO_CLOCK_HZ)
        self._stream.codec_context.thread_count = 1
        # As hardware encoders do; x264's B-frames and macroblock tree differ from run to run.
        options: dict[str, object] = {"crf": str(crf), "preset": "veryfast", "g": "30"}
        self._stream.options = options | {"x264-params": "bframes=0:mbtree=0"}

    def write(self, image_bgr: ImageArray, t_s: float) -> None:
        """Append a frame (H, W, 3) taken at a time.

        OpenCV turns it into YUV: libswscale's result depends on where the array lies in memory.
        """
        planes = np.asarray(cv2.cvtColor(image_bgr, cv2.COLOR_BGR2YUV_I420), dtype=np.uint8)
        frame = av.VideoFrame.from_ndarray(planes, format="yuv420p")
        frame.pts = round(t_s * _VIDEO_CLOCK_HZ)
        frame.time_base = Fraction(1, _VIDEO_CLOCK_HZ)
        self._container.mux(self._stream.encode(frame))

    def __enter__(self) -> Self:
        """Use the writer in a `with` block, which closes the file."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Write what the encoder still holds, and close the file."""
        if error is None:
            self._container.mux(self._stream.encode(None))
        self._container.close()


class SessionWriter:
    """Everything of a session folder but the videos."""

    def __init__(self, folder: Path, config: SimConfig) -> None:
        """Name the recording after its seed."""
        self._folder, self._config = folder, config
        self._recording = str(uuid.UUID(int=config.seed % 2**32, version=4))

    def write_camera(self, name: str, camera: Camera) -> None:
        """Write NAME_camera.json."""
        document: dict[str, object] = {
            "camera_matrix": camera.K.tolist(),
            "distortion_coefficients": [camera.distortion.tolist()],
            "serial_number": camera.serial,
        }
        if camera.lens is LensModel.FISHEYE:
            document["model"] = "fisheye"
        if camera.readout_s is not None:
            document["readout_s"] = camera.readout_s
        self._write_json(f"{name}_camera.json", document)

    def write_frame_times(self, name: str, t_s: FloatArray) -> None:
        """Write NAME_timestamps.csv: one row a frame."""
        self._write_rows(f"{name}_timestamps.csv", ("timestamp [ns]",), ((to_ns(t),) for t in t_s))

    def write_eyes(self, eyes: EyeRecord, looks: tuple[Look, ...]) -> None:
        """Write gaze.csv, fixations.csv and blinks.csv."""
        self._write_gaze(eyes)
        angles = ("azimuth [deg]", "elevation [deg]")
        spans = ("start timestamp [ns]", "end timestamp [ns]", "duration [ms]")
        fixations = (
            (i + 1, *_span(look.start_s, look.end_s), *_px(uv), *_deg(angle))
            for i, (look, uv, angle) in enumerate(
                zip(looks, eyes.looks_px, eyes.looks_deg, strict=True)
            )
        )
        columns = ("fixation id", *spans, "fixation x [px]", "fixation y [px]", *angles)
        self._write_rows("fixations.csv", columns, fixations)
        blinks = ((i + 1, *_span(*span)) for i, span in enumerate(eyes.blinks_s.tolist()))
        self._write_rows("blinks.csv", ("blink id", *spans), blinks)

    def _write_gaze(self, eyes: EyeRecord) -> None:
        columns = (
            "timestamp [ns]", "gaze x [px]", "gaze y [px]", "worn", "fixation id", "blink id",
            "azimuth [deg]", "elevation [deg]",
        )  # fmt: skip
        samples = zip(
            eyes.t_s, eyes.uv_px, eyes.fixation, eyes.blink, eyes.azimuth_elevation_deg, strict=True
        )
        rows = (
            (to_ns(t), *_px(uv), 1, fixation or "", blink or "", *_deg(angle))
            for t, uv, fixation, blink, angle in samples
        )
        self._write_rows("gaze.csv", columns, rows)

    def write_narration(self, said: tuple[Utterance, ...]) -> None:
        """Write narration.vtt."""
        cues = [f"{_clock(u.start_s)} --> {_clock(u.end_s)}\n{u.text}\n\n" for u in said]
        (self._folder / "narration.vtt").write_text("WEBVTT\n\n" + "".join(cues), encoding="utf-8")

    def write_tags(self) -> None:
        """Write tags.yaml."""
        rows = [
            f"  - {{id: {i}, size: {TAG_SIZE_M}, position: [{x}, {y}, 0.0], "
            "orientation: [0, 0, 0, 1]}\n"
            for i, (x, y) in enumerate(TAG_PLACES_WORLD)
        ]
        text = f"family: {TAG_FAMILY}\nframe: world\ntags:\n{''.join(rows)}"
        (self._folder / "tags.yaml").write_text(text, encoding="utf-8")

    def write_info(self) -> None:
        """Write info.json and events.csv."""
        end_ns = to_ns(self._config.seconds)
        info = {
            "recording_id": self._recording,
            "start_time": START_NS,
            "duration": end_ns - START_NS,
            "gaze_frequency": round(self._config.gaze_rate_hz),
            "scene_camera_serial_number": self._config.scene_lens.serial,
            "wearer_name": "simulated",
            "template_data": {},
        }
        self._write_json("info.json", info)
        events = [("recording.begin", START_NS), ("recording.end", end_ns)]
        rows = [(self._recording, t_ns, name, "recording") for name, t_ns in events]
        self._write_csv("events.csv", ("recording id", "timestamp [ns]", "name", "type"), rows)

    def _write_rows(
        self, name: str, columns: tuple[str, ...], rows: Iterable[tuple[object, ...]]
    ) -> None:
        ids = (self._recording, self._recording)
        self._write_csv(name, (*_HEAD, *columns), ((*ids, *row) for row in rows))

    def _write_csv(
        self, name: str, columns: tuple[str, ...], rows: Iterable[tuple[object, ...]]
    ) -> None:
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(rows)
        (self._folder / name).write_text(text.getvalue(), encoding="utf-8")

    def _write_json(self, name: str, document: dict[str, object]) -> None:
        (self._folder / name).write_text(json.dumps(document) + "\n", encoding="utf-8")


def _span(start_s: float, end_s: float) -> tuple[int, int, int]:
    return to_ns(start_s), to_ns(end_s), round((end_s - start_s) * 1e3)


def _px(uv: FloatArray) -> tuple[str, str]:
    return f"{uv[0]:.3f}", f"{uv[1]:.3f}"


def _deg(angle: FloatArray) -> tuple[str, str]:
    return f"{angle[0]:.4f}", f"{angle[1]:.4f}"


def _clock(t_s: float) -> str:
    minutes, milliseconds = divmod(round(max(t_s, 0.0) * 1e3), 60_000)
    hours, minutes = divmod(minutes, 60)
    return f"{hours:02d}:{minutes:02d}:{milliseconds // 1000:02d}.{milliseconds % 1000:03d}"
