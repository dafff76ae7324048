"""Pictures against projections by OpenCV, lens by lens and row by row."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

import gazemap.sim.renderer as renderer_module
from gazemap.geometry.camera import LensModel
from gazemap.sim.config import LENSES, Level, SimConfig
from gazemap.sim.model import Model
from gazemap.sim.renderer import Renderer
from gazemap.sim.sensors import head_shutter
from gazemap.sim.simulate import Script, write_script
from gazemap.sim.still_view import StillView
from gazemap.sim.textures import TAG_PLACES_WORLD
from tests.builders import small_config


def draw(script: Script, t_s: float) -> np.ndarray:
    model = Model(script.room, script.demonstration.blocks)
    renderer = Renderer(script.scene_camera, model)
    shutter = head_shutter(script.scene_camera, script.head, t_s)
    return renderer.render(script.moment(t_s), shutter, renderer.whole).bgr


def found_tags(image: np.ndarray) -> dict[int, np.ndarray]:
    detector = cv2.aruco.ArucoDetector(
        cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    )
    corners, ids, _ = detector.detectMarkers(np.clip(image, 0, 255).astype(np.uint8))
    assert ids is not None
    return {int(i): c.reshape(4, 2).mean(axis=0) for i, c in zip(ids.ravel(), corners, strict=True)}


def tag_px(script: Script, tag_id: int, t_s: float) -> np.ndarray:
    """Return where OpenCV projects the mean of a tag's corners from the pose at a time."""
    R, p = (each[0] for each in script.head.poses(np.array([t_s])))
    x, y = TAG_PLACES_WORLD[tag_id]
    square = np.array([[x + a, y + b, 0.0] for a in (-0.03, 0.03) for b in (-0.03, 0.03)])
    points = ((square - p) @ R).reshape(-1, 1, 3)
    camera, zero = script.scene_camera, np.zeros(3)
    lens = cv2.fisheye if camera.lens is LensModel.FISHEYE else cv2
    uv = lens.projectPoints(points, zero, zero, camera.K, camera.distortion)[0]
    return uv.reshape(4, 2).mean(axis=0)


def config_of(lens: str, **imaging: float) -> SimConfig:
    config = small_config(scale=0.8)
    model, distortion = LENSES[lens]
    scene_lens = replace(config.scene_lens, model=model, distortion=distortion)
    return replace(config, scene_lens=scene_lens, imaging=replace(config.imaging, **imaging))


@pytest.mark.parametrize("lens", sorted(LENSES))
def test_tags_are_drawn_where_the_lens_puts_them(lens: str) -> None:
    script = write_script(config_of(lens))
    found = found_tags(draw(script, 2.0))
    assert len(found) >= 3
    errors = np.array([uv - tag_px(script, i, 2.0) for i, uv in found.items()])
    assert np.abs(errors).max() < 0.7
    assert np.abs(errors.mean(axis=0)).max() < 0.35  # half a pixel's shift would show


def test_rows_are_exposed_one_after_another() -> None:
    readout_s, t_s = 0.06, 2.75
    script = write_script(config_of("pinhole8", readout_s=readout_s))
    as_exposed, as_still = [], []
    for tag_id, uv in found_tags(draw(script, t_s)).items():
        delay_s = (uv[1] / (script.scene_camera.height_px - 1) - 0.5) * readout_s
        as_exposed.append(np.abs(uv - tag_px(script, tag_id, t_s + delay_s)).max())
        as_still.append(np.abs(uv - tag_px(script, tag_id, t_s)).max())
    assert max(as_exposed) < 0.7
    assert max(as_still) > 1.0


def test_cells_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    script = write_script(replace(small_config(level=Level.MEDIUM), seed=3))
    quick = draw(script, 3.0)
    monkeypatch.setattr(renderer_module, "CELL_PX", 1)
    assert np.abs(quick - draw(script, 3.0)).max() < 1e-3


def test_still_camera_draws_what_a_full_drawing_would() -> None:
    script = write_script(replace(small_config(level=Level.MEDIUM, scale=0.4), seed=3))
    model = Model(script.room, script.demonstration.blocks)
    camera, T_world_cam = script.overhead_camera, script.T_world_overhead
    view = StillView(camera, model, T_world_cam)
    for t_s in (0.5, 2.5, 3.0, 3.5, 4.5, 6.0):
        kept = view.render(script.moment(t_s)).bgr
        anew = StillView(camera, model, T_world_cam).render(script.moment(t_s)).bgr
        assert np.abs(kept - anew).max() < 1.0
