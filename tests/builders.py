"""Small simulated sessions for tests: drawn once a run, with the script that they follow."""

from dataclasses import dataclass, replace
from pathlib import Path

from gazemap.sim.config import Level, SimConfig, preset, resized
from gazemap.sim.simulate import Script, simulate


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SimulatedSession:
    """Folders of a session and of its truth, and everything that was drawn for them."""

    session: Path
    truth: Path
    script: Script


def small_config(
    *, level: Level = Level.EASY, seed: int = 7, seconds: float = 8.0, scale: float = 0.6
) -> SimConfig:
    """Return a session of one pick and place with small pictures at a low rate."""
    config = replace(preset(level), seed=seed, seconds=seconds)
    scene, overhead = config.scene_lens, config.overhead_lens
    return replace(
        config,
        scene_lens=resized(
            scene,
            width_px=2 * round(scene.width_px * scale / 2),
            height_px=2 * round(scene.height_px * scale / 2),
            rate_hz=15.0,
        ),
        overhead_lens=resized(
            overhead,
            width_px=2 * round(overhead.width_px * scale / 2),
            height_px=2 * round(overhead.height_px * scale / 2),
            rate_hz=5.0,
        ),
    )


def build_session(folder: Path, config: SimConfig) -> SimulatedSession:
    """Simulate into a folder."""
    script = simulate(config, folder, progress=lambda *_: None)
    return SimulatedSession(session=folder / "session", truth=folder / "truth", script=script)
