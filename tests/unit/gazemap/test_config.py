from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

import pytest

from gazemap.config import load_config
from gazemap.errors import ConfigError


class Mode(StrEnum):
    FAST = "fast"
    SLOW = "slow"


@dataclass(frozen=True, slots=True, kw_only=True)
class Inner:
    width_px: int = 3
    sigma_m: float = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Outer:
    mode: Mode = Mode.FAST
    names: tuple[str, ...] = ()
    rig: Path | None = None
    inner: Inner = field(default_factory=Inner)


def load(tmp_path, text):
    (tmp_path / "c.toml").write_text(text)
    return load_config(Outer, tmp_path / "c.toml")


def test_values_of_the_file_stand_over_the_defaults(tmp_path):
    loaded = load(
        tmp_path, 'mode = "slow"\nnames = ["a"]\nrig = "calib/demo"\n[inner]\nsigma_m = 2\n'
    )
    inner = Inner(width_px=3, sigma_m=2.0)
    assert loaded == Outer(mode=Mode.SLOW, names=("a",), rig=Path("calib/demo"), inner=inner)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[inner]\nwidht_px = 4\n", "inner: unknown key 'widht_px'; known are: sigma_m, width_px"),
        ("[inner]\nwidth_px = 4.5\n", "inner: width_px: int expected, got 4.5"),
        ('mode = "medium"\n', r"mode: one of \['fast', 'slow'\] expected"),
        ("inner = 3\n", "inner: a table expected, got 3"),
        ("mode = \n", "no valid TOML"),
    ],
)
def test_what_does_not_fit_is_refused_with_its_path(tmp_path, text, message):
    with pytest.raises(ConfigError, match=message):
        load(tmp_path, text)


def test_a_missing_file_is_one_line(tmp_path):
    with pytest.raises(ConfigError, match=r"none\.toml: cannot be read"):
        load_config(Outer, tmp_path / "none.toml")
