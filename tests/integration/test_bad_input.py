"""What cannot be used is exit 1 and one line that says what, where and what to do."""

import sys

import pytest

from services.cli.main import main
from tests.session_writer import SessionWriter


def without_video(writer):
    (writer.path / "scene.mp4").unlink()
    return "scene.mp4: the scene video is missing"


def cut_video(writer):
    writer.cut("scene.mp4", share=0.6)
    return "scene.mp4: 0 of 24 frames can be read"


def cut_video_with_index(writer):
    writer.video("scene.mp4", faststart=True)
    writer.cut("scene.mp4", share=0.6)
    return "of 24 frames can be read"


def video_without_timestamps(writer):
    (writer.path / "world_timestamps.csv").unlink()
    return "world_timestamps.csv: the video's timestamps are missing"


def gaze_of_nan(writer):
    writer.gaze([writer.gaze_row(1), writer.gaze_row(2, u="nan", v="nan")])
    return "gaze.csv, line 3: column 'gaze x [px]'"


def unsorted_gaze(writer):
    writer.gaze([writer.gaze_row(1), writer.gaze_row(9), writer.gaze_row(2, u="", v="")])
    return "gaze.csv, line 4: column 'timestamp [ns]'"


def camera_of_another_resolution(writer):
    writer.camera(camera_matrix=[[300.0, 0, 161], [0, 302.0, 118], [0, 0, 1]])
    return "scene_camera.json: the camera is for images of another resolution"


def empty_narration(writer):
    writer.text("narration.vtt", "WEBVTT\n")
    return "narration.vtt: the narration is empty"


def unknown_tag_family(writer):
    writer.text("tags.yaml", "family: tag49h12\nframe: world\ntags: []\n")
    return "tags.yaml: tag family 'tag49h12' is unknown"


def no_session(writer):
    for file in writer.path.iterdir():
        file.unlink()
    writer.text("notes.txt", "nothing here")
    return "no recording in it"


DAMAGES = [
    without_video,
    cut_video,
    cut_video_with_index,
    video_without_timestamps,
    gaze_of_nan,
    unsorted_gaze,
    camera_of_another_resolution,
    empty_narration,
    unknown_tag_family,
    no_session,
]
COMMANDS = {
    "rebuild": ["--out", "out"],
    "slam": ["--out", "out/path.tum"],
    "import": ["out/session.mcap"],
    "replay": [],
}


@pytest.mark.parametrize("damage", DAMAGES, ids=lambda each: each.__name__)
@pytest.mark.parametrize("command", COMMANDS)
def test_bad_input_is_one_line_and_leaves_the_output_alone(
    tmp_path, monkeypatch, capsys, command, damage
):
    writer = SessionWriter(path=tmp_path / "walk")
    writer.write_all()
    said = damage(writer)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "kept.txt").write_text("as it was")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["gazemap", command, str(writer.path), *COMMANDS[command]])
    with pytest.raises(SystemExit) as left:
        main()
    out, err = capsys.readouterr()
    assert left.value.code == 1
    assert said in err
    assert "; " in err
    assert err.count("\n") == 1
    assert out == ""
    assert [file.name for file in (tmp_path / "out").iterdir()] == ["kept.txt"]


def test_a_rebuild_never_writes_into_its_session(tmp_path, monkeypatch, capsys):
    writer = SessionWriter(path=tmp_path / "walk")
    writer.write_all()
    before = sorted(writer.path.rglob("*"))
    for out in (writer.path, writer.path / "out"):
        arguments = ["gazemap", "rebuild", str(writer.path), "--out", str(out)]
        monkeypatch.setattr(sys, "argv", arguments)
        with pytest.raises(SystemExit) as left:
            main()
        assert left.value.code == 1
        assert "it lies in the session; name a folder outside" in capsys.readouterr().err
    assert sorted(writer.path.rglob("*")) == before


def test_an_output_that_cannot_be_written_is_one_line(tmp_path, monkeypatch, capsys):
    writer = SessionWriter(path=tmp_path / "walk")
    writer.write_all()
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "kept.txt").write_text("as it was")
    for out, said in (("taken", "taken: Is a directory"), ("walk/scene.mp4/a.mcap", "scene.mp4: ")):
        target = str(tmp_path / out)
        monkeypatch.setattr(sys, "argv", ["gazemap", "import", str(writer.path), target])
        with pytest.raises(SystemExit) as left:
            main()
        err = capsys.readouterr().err
        assert left.value.code == 1
        assert said in err
        assert err.count("\n") == 1
    assert sorted(file.name for file in tmp_path.iterdir()) == ["taken", "walk"]
