"""`python -m services.warm_up`: compile once, at set-up, what the first run would wait for.

The compiled kernels are kept beside their sources. A small session through the whole chain meets
all of them with the types that they are used with.
"""

import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from gazemap.live import warm_up
from gazemap.scene.ray_order import coherent_order
from gazemap.sim.config import SimConfig, resized
from gazemap.sim.simulate import simulate
from gazemap.slam.live.warm_up import warm_up_mapping
from services.rebuild.run import RebuildConfig, rebuild


def _silent(stage: str, done: int, total: int) -> None:
    """Take a report and show nothing."""


def main() -> None:
    """Simulate and rebuild a few seconds in a folder that is thrown away."""
    sys.stderr.write("compiling the numerical kernels, once\n")
    base = SimConfig(seconds=6.0)
    config = replace(
        base,
        scene_lens=resized(base.scene_lens, width_px=400, height_px=300, rate_hz=10.0),
        overhead_lens=resized(base.overhead_lens, width_px=480, height_px=360, rate_hz=4.0),
    )
    warm_up()
    warm_up_mapping()
    coherent_order(np.zeros((1, 6), dtype=np.float32), np.zeros(3))
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        simulate(config, out, progress=_silent)
        rebuild(out / "session", out / "rebuilt", RebuildConfig(), progress=_silent)


if __name__ == "__main__":
    main()
