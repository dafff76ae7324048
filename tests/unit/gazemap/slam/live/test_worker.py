"""Mapping's process ends with the one that tracks."""

import os
import select
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[5]
TRACKER = """
import time
import numpy as np
from gazemap.geometry.camera import Camera
from gazemap.slam.live.config import LiveConfig
from gazemap.slam.live.worker import ProcessLink

if __name__ == "__main__":
    K = np.array([[300.0, 0, 160], [0, 300, 120], [0, 0, 1]])
    camera = Camera(width_px=320, height_px=240, K=K, distortion=np.zeros(5))
    link = ProcessLink(camera, layout=None, config=LiveConfig())
    print(link._process.pid, flush=True)
    time.sleep(100)
"""


def test_mapping_ends_with_a_tracker_that_was_killed(tmp_path):
    script = tmp_path / "tracker.py"
    script.write_text(TRACKER)
    tracker = subprocess.Popen(
        [sys.executable, str(script)],
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    try:
        mapping = os.pidfd_open(int(tracker.stdout.readline()))
    finally:
        tracker.kill()
        tracker.communicate(timeout=10)
    assert select.select([mapping], [], [], 10)[0]
