"""The story of one simulated session: who does what, what is seen, what is written."""

import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gazemap.errors import InputError
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Overhead, Pose, World
from gazemap.ports import Progress
from gazemap.sim.config import SimConfig
from gazemap.sim.eyes import Look, look_around
from gazemap.sim.eyetracker import EyeRecord, record_eyes
from gazemap.sim.hand import hand_at
from gazemap.sim.head import HeadPath, move_head
from gazemap.sim.model import Model, Moment
from gazemap.sim.recording import SessionWriter, VideoWriter, frame_times_s
from gazemap.sim.renderer import Renderer
from gazemap.sim.sensors import (
    Sensor,
    brightness,
    build_camera,
    hang_overhead,
    head_shutter,
    motion_blur,
)
from gazemap.sim.speech import Utterance, speak
from gazemap.sim.still_view import StillView
from gazemap.sim.surfaces import Room, build_room
from gazemap.sim.tabletop import Demonstration, demonstrate
from gazemap.sim.truth import truth_document, write_trajectory, write_truth


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Script:
    """All of a session before a picture is taken: enough to test against."""

    config: SimConfig
    demonstration: Demonstration
    looks: tuple[Look, ...]
    head: HeadPath
    said: tuple[Utterance, ...]
    eyes: EyeRecord
    room: Room
    scene_camera: Camera
    overhead_camera: Camera
    T_world_overhead: Pose[World, Overhead]

    def moment(self, t_s: float) -> Moment:
        """Return the world at a time."""
        hand = hand_at(self.demonstration, t_s) if self.config.person.has_hand else None
        return Moment(centres_world=self.demonstration.centres_world(t_s), hand=hand)


def write_script(config: SimConfig) -> Script:
    """Draw a session; each part has a generator of its own, so that one option changes one part."""
    names = ("demonstration", "looks", "head", "said", "eyes", "room", "overhead")
    seeds = np.random.SeedSequence(config.seed).spawn(len(names))
    rng = {name: np.random.default_rng(s) for name, s in zip(names, seeds, strict=True)}
    demonstration = demonstrate(config, rng["demonstration"])
    looks = look_around(demonstration, config.person, seconds=config.seconds, rng=rng["looks"])
    head = move_head(looks, seconds=config.seconds, rng=rng["head"])
    scene_camera = build_camera(config.scene_lens, readout_s=config.imaging.readout_s)
    return Script(
        config=config,
        demonstration=demonstration,
        looks=looks,
        head=head,
        said=speak(demonstration.steps, config.person, rng["said"]),
        eyes=record_eyes(looks, head, scene_camera, config, rng["eyes"]),
        room=build_room(demonstration.blocks, config.tabletop, rng["room"]),
        scene_camera=scene_camera,
        overhead_camera=build_camera(config.overhead_lens),
        T_world_overhead=hang_overhead(rng["overhead"]),
    )


def simulate(config: SimConfig, out: Path, *, progress: Progress) -> Script:
    """Write `out/session` and `out/truth`, both whole or neither; return what was simulated.

    Raises:
        InputError: if a session or a truth is there already, or the folder cannot be written.
    """
    for name in ("session", "truth"):
        if (out / name).exists():
            raise InputError("is there already", where=out / name, todo="name another folder")
    script = write_script(config)
    try:
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".simulating-", dir=out) as unfinished:
            session, truth = Path(unfinished) / "session", Path(unfinished) / "truth"
            _write_truth(script, truth)
            _write_session(script, session, progress)
            session.rename(out / "session")
            truth.rename(out / "truth")
    except OSError as error:
        todo = "name a folder that can be written, with room"
        raise InputError(f"cannot be written ({error.strerror})", where=out, todo=todo) from error
    return script


def _write_truth(script: Script, truth: Path) -> None:
    truth.mkdir()
    times_s = frame_times_s(script.config.scene_lens, script.config.seconds)
    write_trajectory(truth / "trajectory.tum", script.head, times_s)
    document = truth_document(
        script.config,
        script.demonstration,
        script.looks,
        T_world_overhead=script.T_world_overhead,
        offset_px=script.eyes.offset_px,
    )
    write_truth(truth / "truth.json", document)


def _write_session(script: Script, session: Path, progress: Progress) -> None:
    session.mkdir()
    config, writer = script.config, SessionWriter(session, script.config)
    writer.write_camera("scene", script.scene_camera)
    writer.write_frame_times("world", frame_times_s(config.scene_lens, config.seconds))
    if config.has_overhead:
        writer.write_camera("overhead", script.overhead_camera)
        overhead_times_s = frame_times_s(config.overhead_lens, config.seconds)
        writer.write_frame_times("overhead", overhead_times_s)
    writer.write_eyes(script.eyes, script.looks)
    writer.write_narration(script.said)
    writer.write_tags()
    writer.write_info()
    _film(script, session, progress)


def _film(script: Script, session: Path, progress: Progress) -> None:
    """Film with both cameras at once, one thread each."""
    model = Model(script.room, script.demonstration.blocks)
    with ThreadPoolExecutor(2) as pool:
        films = [pool.submit(_film_scene, script, model, session / "scene.mp4", progress)]
        if script.config.has_overhead:
            films.append(pool.submit(_film_overhead, script, model, session / "overhead.mp4"))
        for film in films:
            film.result()


def _film_scene(script: Script, model: Model, path: Path, progress: Progress) -> None:
    config, camera = script.config, script.scene_camera
    renderer = Renderer(camera, model)
    sensor = Sensor(config.imaging, camera, np.random.default_rng([config.seed, 1]))
    times_s = frame_times_s(config.scene_lens, config.seconds)
    with VideoWriter(path, config.scene_lens, crf=config.imaging.crf) as video:
        for i, t_s in enumerate(times_s.tolist()):
            shutter = head_shutter(camera, script.head, t_s)
            rendering = renderer.render(script.moment(t_s), shutter, renderer.whole)
            exposure_s = config.imaging.exposure_s
            blur = (
                motion_blur(rendering, camera, script.head, t_s=t_s, exposure_s=exposure_s)
                if exposure_s
                else None
            )
            gain = brightness(t_s, config.imaging)
            video.write(sensor.expose(rendering, gain=gain, blur_map=blur), t_s)
            progress("simulate", i + 1, len(times_s))


def _film_overhead(script: Script, model: Model, path: Path) -> None:
    config, camera = script.config, script.overhead_camera
    view = StillView(camera, model, script.T_world_overhead)
    sensor = Sensor(config.imaging, camera, np.random.default_rng([config.seed, 2]))
    with VideoWriter(path, config.overhead_lens, crf=config.imaging.crf) as video:
        for t_s in frame_times_s(config.overhead_lens, config.seconds).tolist():
            rendering = view.render(script.moment(t_s))
            gain = brightness(t_s, config.imaging)
            video.write(sensor.expose(rendering, gain=gain, blur_map=None), t_s)
