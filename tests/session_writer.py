"""A small session folder, written without the code under test."""

import json
from dataclasses import dataclass
from pathlib import Path

import av
import numpy as np

START_NS = 1_760_000_000_000_000_000
FRAME_COUNT = 24
WIDTH_PX, HEIGHT_PX = 160, 120
CAMERA = {
    "camera_matrix": [[150.0, 0, 80.5], [0, 151.0, 59.0], [0, 0, 1]],
    "distortion_coefficients": [[-0.1, 0.05, 0.0, 0.001, 0.0, 0.1, 0.05, 0.02]],
    "serial_number": "abc",
}
NARRATION = """WEBVTT

1
00:00:00.100 --> 00:00:00.500
pick up the
red cube

NOTE a remark

00:00.600 --> 00:00.700 align:start
<v Ann>put it &amp; stop
"""
TAGS = """family: tag36h11
frame: world
tags:
  - {id: 3, size: 0.06, position: [0.1, 0.2, 0], orientation: [0, 0, 1, 0]}
"""
GAZE_HEADER = (
    "section id,recording id,timestamp [ns],gaze x [px],gaze y [px],worn,"
    "fixation id,blink id,azimuth [deg],elevation [deg]\n"
)


@dataclass
class SessionWriter:
    """Writes the parts of a session folder."""

    path: Path
    start_ns: int = START_NS

    @property
    def frame_t_ns(self) -> list[int]:
        # Uneven on purpose: a reader that multiplies an index by a frame rate is caught.
        return [self.start_ns + 33_333_333 * i + 5_000_000 * (i % 3) for i in range(FRAME_COUNT)]

    def write_all(self) -> None:
        self.path.mkdir(parents=True)
        self.video("scene.mp4")
        self.times("world_timestamps.csv", self.frame_t_ns)
        self.text("scene_camera.json", json.dumps(CAMERA))
        self.gaze([self.gaze_row(1), self.gaze_row(6, u="", v=""), self.gaze_row(11, worn="0")])
        self.text("narration.vtt", NARRATION)
        self.text("tags.yaml", TAGS)

    def text(self, name: str, content: str) -> None:
        (self.path / name).write_text(content)

    def camera(self, **changes: object) -> None:
        kept = {key: value for key, value in (CAMERA | changes).items() if value is not None}
        self.text("scene_camera.json", json.dumps(kept))

    def times(self, name: str, times: list[int]) -> None:
        rows = "".join(f"s,r,{t}\n" for t in times)
        self.text(name, "section id,recording id,timestamp [ns]\n" + rows)

    def gaze_row(self, ms: int, *, u: str = "10.5", v: str = "20.25", worn: str = "1") -> str:
        blink = "" if u else "1"
        return f"s,r,{self.start_ns + ms * 1_000_000},{u},{v},{worn},1,{blink},0.1,0.2\n"

    def gaze(self, rows: list[str]) -> None:
        self.text("gaze.csv", GAZE_HEADER + "".join(rows))

    def video(
        self, name: str, *, count: int = FRAME_COUNT, faststart: bool = False, scale: int = 1
    ) -> None:
        write_video(self.path / name, count=count, faststart=faststart, scale=scale)

    def cut(self, name: str, *, share: float) -> None:
        file = self.path / name
        whole = file.read_bytes()
        file.write_bytes(whole[: int(len(whole) * share)])


def write_video(
    path: Path,
    *,
    count: int = FRAME_COUNT,
    first: int = 0,
    codec: str = "libx264",
    pixels: str = "yuv420p",
    faststart: bool = False,
    scale: int = 1,
) -> None:
    options = {"movflags": "faststart"} if faststart else {}
    with av.open(str(path), "w", options=options) as container:
        stream = container.add_stream(codec, rate=30)
        stream.width, stream.height = WIDTH_PX * scale, HEIGHT_PX * scale
        stream.pix_fmt = pixels
        for i in range(first, first + count):
            picture = av.VideoFrame.from_ndarray(
                picture_of(i).repeat(scale, axis=0).repeat(scale, axis=1), format="bgr24"
            )
            container.mux(stream.encode(picture))
        container.mux(stream.encode())


def picture_of(i: int) -> np.ndarray:
    """A picture whose brightness tells its index."""
    noise = np.random.default_rng(5).integers(0, 6, size=(HEIGHT_PX, WIDTH_PX, 3))
    return (noise + 10 + 9 * i).astype(np.uint8)
