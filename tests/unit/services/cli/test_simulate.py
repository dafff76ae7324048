"""`gazemap simulate`: its options reach the session."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from gazemap.errors import ConfigError
from services.cli.simulate import command

SMALL = [
    "--size", "160", "120", "--overhead-size", "160", "120", "--fps", "5", "--overhead-fps", "2",
    "--seconds", "6",
]  # fmt: skip


def test_options_reach_the_session(tmp_path: Path) -> None:
    words = ["--colours", "green,orange", "--shapes", "brick,tile", "--objects", "4"]
    lens = ["--lens", "fisheye", "--readout-s", "0.01", "--level", "hard", "--seed", "5"]
    arguments = [str(tmp_path / "out"), *SMALL, *words, *lens, "--relations", "behind"]
    result = CliRunner().invoke(command, arguments, catch_exceptions=False)
    assert result.exit_code == 0
    camera = json.loads((tmp_path / "out/session/scene_camera.json").read_text())
    assert camera["model"] == "fisheye"
    assert camera["readout_s"] == 0.01
    truth = json.loads((tmp_path / "out/truth/truth.json").read_text())
    assert (truth["seed"], truth["level"]) == (5, "hard")
    assert {o["colour"] for o in truth["objects"]} == {"green", "orange"}
    assert [row.get("relation") for row in truth["plan"]] == [None, "behind"]


def test_session_without_an_overhead_camera(tmp_path: Path) -> None:
    arguments = [str(tmp_path / "out"), *SMALL, "--no-overhead"]
    assert CliRunner().invoke(command, arguments).exit_code == 0
    assert not list((tmp_path / "out/session").glob("overhead*"))


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--colours", "mauve"], "mauve"),
        (["--seconds", "2"], "below 6"),
        (["--seconds", "nan"], "seconds: a number expected, got nan"),
        (["--seconds", "inf"], "seconds inf is no length"),
        (["--seed", "-1"], "seed -1 is negative"),
        (["--size", "161", "120"], "even"),
        (["--relations", "under"], "under"),
    ],
)
def test_wrong_values_are_refused(tmp_path: Path, arguments: list[str], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        CliRunner().invoke(command, [str(tmp_path / "out"), *arguments], catch_exceptions=False)
    assert not (tmp_path / "out").exists()
