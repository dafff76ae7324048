"""What is written, and that pictures and truth tell the same story."""

import csv
import filecmp
import json
from dataclasses import replace
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gazemap.errors import InputError
from gazemap.sim.config import Level
from gazemap.sim.simulate import simulate, write_script
from gazemap.sim.vocabulary import COLOURS_BGR
from tests.builders import SimulatedSession, build_session, small_config

PRODUCED = {
    "scene.mp4", "world_timestamps.csv", "scene_camera.json", "gaze.csv", "fixations.csv",
    "blinks.csv", "events.csv", "info.json", "narration.vtt", "overhead.mp4",
    "overhead_timestamps.csv", "overhead_camera.json", "tags.yaml",
}  # fmt: skip


def frames_of(video: Path) -> list[tuple[float, np.ndarray]]:
    with av.open(str(video)) as container:
        decoded = list(container.decode(video=0))
    return [(float(f.pts * f.time_base), f.to_ndarray(format="bgr24")) for f in decoded]


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def pinhole_px(points_world: np.ndarray, T_world_cam: np.ndarray, camera_file: Path) -> np.ndarray:
    """Project with nothing of ours: the expected pixel must not come from the simulator."""
    camera = json.loads(camera_file.read_text())
    T_cam_world = np.linalg.inv(T_world_cam)
    points_cam = points_world @ T_cam_world[:3, :3].T + T_cam_world[:3, 3]
    K, distortion = np.array(camera["camera_matrix"]), np.array(camera["distortion_coefficients"])
    uv = cv2.projectPoints(points_cam, np.zeros(3), np.zeros(3), K, distortion)[0]
    return uv[:, 0]


def true_poses(truth: Path) -> np.ndarray:
    table = np.loadtxt(truth / "trajectory.tum")
    poses = np.tile(np.eye(4), (len(table), 1, 1))
    poses[:, :3, :3] = Rotation.from_quat(table[:, 4:]).as_matrix()
    poses[:, :3, 3] = table[:, 1:4]
    return poses


def colour_error(image: np.ndarray, uv: np.ndarray, word: str) -> float:
    """Return the angle in degrees between a pixel's colour and a word's."""
    u, v = np.round(uv).astype(int)
    seen = image[v - 1 : v + 2, u - 1 : u + 2].reshape(-1, 3).astype(float).mean(axis=0)
    wanted = np.array(COLOURS_BGR[word], dtype=float)
    cosine = seen @ wanted / np.linalg.norm(seen) / np.linalg.norm(wanted)
    return float(np.degrees(np.arccos(min(cosine, 1.0))))


def hidden(objects: list[dict], which: str, top: np.ndarray) -> bool:
    """Whether something stands on a thing whose top is given, or close before it."""
    others = [np.array(o[which])[:3, 3] for o in objects]
    return any(
        (np.abs(p[:2] - top[:2]).max() < 0.01 and p[2] > top[2])
        or (abs(p[0] - top[0]) < 0.05 and 0.01 < top[1] - p[1] < 0.12 and p[2] > top[2] - 0.01)
        for p in others
    )


def inside(uv: np.ndarray, image: np.ndarray) -> bool:
    return bool((uv > 4).all() and (uv < np.array(image.shape[1::-1]) - 5).all())


def test_session_folder_holds_the_promised_files(small_session: SimulatedSession) -> None:
    assert {path.name for path in small_session.session.iterdir()} == PRODUCED
    assert {path.name for path in small_session.truth.iterdir()} == {"truth.json", "trajectory.tum"}


def test_videos_have_a_timestamp_for_each_frame(small_session: SimulatedSession) -> None:
    for video, times in (("scene", "world"), ("overhead", "overhead")):
        rows = rows_of(small_session.session / f"{times}_timestamps.csv")
        t_ns = np.array([int(row["timestamp [ns]"]) for row in rows])
        shown_s = np.array([t for t, _ in frames_of(small_session.session / f"{video}.mp4")])
        assert len(shown_s) == len(t_ns)
        assert np.abs(shown_s - (t_ns - t_ns[0]) / 1e9).max() < 1e-4


def test_objects_are_seen_where_the_truth_has_them(small_session: SimulatedSession) -> None:
    objects = json.loads((small_session.truth / "truth.json").read_text())["objects"]
    frames = frames_of(small_session.session / "scene.mp4")
    poses = true_poses(small_session.truth)
    camera = small_session.session / "scene_camera.json"
    seen = 0
    for i, which in ((0, "start"), (len(frames) - 1, "end")):
        image = frames[i][1]
        for thing in objects:
            place = np.array(thing[which])
            top = place[:3, 3] + [0.0, 0.0, thing["size"][2] / 2]
            uv = pinhole_px(top[None], poses[i], camera)[0]
            if hidden(objects, which, top) or not inside(uv, image):
                continue
            seen += 1
            assert colour_error(image, uv, thing["colour"]) < 8.0, thing
    assert seen >= 10


def test_overhead_camera_sees_the_objects_too(small_session: SimulatedSession) -> None:
    truth = json.loads((small_session.truth / "truth.json").read_text())
    image = frames_of(small_session.session / "overhead.mp4")[0][1]
    tops = [np.array(o["start"])[:3, 3] + [0.0, 0.0, o["size"][2] / 2] for o in truth["objects"]]
    uv = pinhole_px(
        np.array(tops),
        np.array(truth["T_world_overhead"]),
        small_session.session / "overhead_camera.json",
    )
    errors = [
        colour_error(image, p, o["colour"]) for p, o in zip(uv, truth["objects"], strict=True)
    ]
    assert max(errors) < 8.0


def test_tags_are_found_at_their_true_places(small_session: SimulatedSession) -> None:
    detector = cv2.aruco.ArucoDetector(
        cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    )
    places = {0: (-0.54, -0.34), 1: (0.54, -0.34), 2: (-0.54, 0.34), 3: (0.54, 0.34)}
    places |= {4: (0.0, 0.36), 5: (0.0, -0.36)}
    poses = true_poses(small_session.truth)
    camera = small_session.session / "scene_camera.json"
    errors = []
    for i, (_, image) in enumerate(frames_of(small_session.session / "scene.mp4")[::10]):
        corners, ids, _ = detector.detectMarkers(image)
        for found, tag_id in zip(corners, [] if ids is None else ids.ravel(), strict=False):
            x, y = places[int(tag_id)]
            square = [(x - 0.03, y + 0.03), (x + 0.03, y + 0.03)]
            square += [(x + 0.03, y - 0.03), (x - 0.03, y - 0.03)]
            world = np.array([(*corner, 0.0) for corner in square])
            uv = pinhole_px(world, poses[10 * i], camera)
            errors.append(np.abs(found.reshape(4, 2).mean(axis=0) - uv.mean(axis=0)).max())
    assert len(errors) > 10
    assert np.median(errors) < 0.5


def test_fixations_are_on_what_the_truth_says(small_session: SimulatedSession) -> None:
    truth = json.loads((small_session.truth / "truth.json").read_text())
    recorded = {int(r["fixation id"]): r for r in rows_of(small_session.session / "fixations.csv")}
    poses = true_poses(small_session.truth)
    rate_hz = small_session.script.config.scene_lens.rate_hz
    camera = small_session.session / "scene_camera.json"
    errors = []
    for fixation in truth["fixations"]:
        middle_s = ((fixation["start_ns"] + fixation["end_ns"]) / 2 - truth["T0"]) / 1e9
        i = min(round(middle_s * rate_hz), len(poses) - 1)
        uv = pinhole_px(np.array([fixation["point"]]), poses[i], camera)[0]
        row = recorded[fixation["id"]]
        seen = [float(row["fixation x [px]"]), float(row["fixation y [px]"])]
        errors.append(np.array(seen) - uv - truth["gaze_bias_px"])
    # The nearest frame is up to 33 ms away, in which the head turns by a pixel or so.
    assert 0.1 < np.median(np.abs(errors)) < 3.0
    assert np.abs(np.median(errors, axis=0)).max() < 1.0


def test_gaze_scatters_as_much_as_was_asked() -> None:
    config = small_config(level=Level.HARD)
    eyes = write_script(config).eyes
    within = np.flatnonzero((eyes.fixation[1:] == eyes.fixation[:-1]) & (eyes.fixation[1:] > 0))
    sigma_px = np.diff(eyes.uv_px, axis=0)[within].std() / np.sqrt(2.0)
    asked_px = np.radians(config.person.gaze_noise_deg) * eyes_focal_px(config)
    assert 0.9 * asked_px < sigma_px < 1.15 * asked_px
    offset_deg = np.degrees(np.linalg.norm(eyes.offset_px) / eyes_focal_px(config))
    assert offset_deg == pytest.approx(config.person.gaze_offset_deg)


def eyes_focal_px(config) -> float:
    return config.scene_lens.focal_px[0] * config.scene_lens.width_px / 800


def test_equal_seeds_give_equal_files(tmp_path: Path) -> None:
    config = small_config(level=Level.HARD, seed=3, seconds=6.0, scale=0.2)
    one, two = build_session(tmp_path / "one", config), build_session(tmp_path / "two", config)
    for a, b in ((one.session, two.session), (one.truth, two.truth)):
        names = [path.name for path in a.iterdir()]
        assert filecmp.cmpfiles(a, b, names, shallow=False) == (names, [], [])


def test_another_seed_gives_another_session(tmp_path: Path) -> None:
    config = small_config(seconds=6.0, scale=0.2)
    one = build_session(tmp_path / "one", config)
    two = build_session(tmp_path / "two", replace(config, seed=8))
    for name in ("gaze.csv", "scene.mp4", "narration.vtt"):
        assert (one.session / name).read_bytes() != (two.session / name).read_bytes()


def test_folder_with_a_session_is_left_as_it_was(tmp_path: Path) -> None:
    (tmp_path / "session").mkdir()
    with pytest.raises(InputError, match="is there already; name another folder"):
        simulate(small_config(), tmp_path, progress=lambda *_: None)
    assert [path.name for path in tmp_path.iterdir()] == ["session"]


def test_stopped_simulation_leaves_nothing(tmp_path: Path) -> None:
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(small_config(scale=0.2), tmp_path / "out", progress=stop)
    assert list((tmp_path / "out").iterdir()) == []
