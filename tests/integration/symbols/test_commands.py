"""`gazemap symbols` from files to files."""

import csv
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner, Result

from grounding.errors import InputError
from grounding.symbols.simulated import Scene, Shape, Thing, draw_patch
from services.cli.symbols import command
from tests.patches import COLOURS, SHAPES

HOSTILE = {
    "text.jpg": b"hello",
    "empty.png": b"",
    "cut.png": cv2.imencode(".png", np.full((64, 64, 3), 90, np.uint8))[1].tobytes()[:60],
}


def run(*arguments: object) -> Result:
    return CliRunner().invoke(command, [str(each) for each in arguments], catch_exceptions=False)


def draw(path: Path, colour: str, shape: Shape, seed: int) -> Path:
    thing = Thing(colour=colour, shape=shape)
    cv2.imwrite(str(path), draw_patch(thing, Scene(), np.random.default_rng(seed)))
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with LABELS.csv, its images and a fitted model; two images are broken."""
    folder = tmp_path_factory.mktemp("patches")
    rng = np.random.default_rng(0)
    rows = [("image", "symbols", "segment", "mm_per_px")]
    for number in range(150):
        colour, shape = COLOURS[number // 5 % 3], SHAPES[number // 15 % 3]
        draw(folder / f"{number}.png", colour, Shape(shape), number)
        said = f"{colour} {shape}" if number // 5 % 6 else f"{COLOURS[rng.integers(3)]} {shape}"
        rows.append((f"{number}.png", said, str(number // 5), "1.0"))
    for name, content in HOSTILE.items():
        (folder / name).write_bytes(content)
        rows.append((name, "red cube", "x", "1.0"))
    with (folder / "labels.csv").open("w", newline="") as file:
        csv.writer(file).writerows(rows)
    fitted = run("fit", folder / "labels.csv", "--out", folder / "model.json")
    assert fitted.exit_code == 0
    assert len(fitted.stderr.splitlines()) == len(HOSTILE)
    assert "colour: blue" in fitted.stdout
    return folder


def read(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_rows_are_as_promised(folder: Path, tmp_path: Path):
    (folder / "list.csv").write_text("image,mm_per_px,note\n3.png,1.0,a\n17.png,1.0,b\n")
    out = tmp_path / "out.csv"
    result = run("classify", folder / "model.json", "--list", folder / "list.csv", "--out", out)
    assert result.exit_code == 0
    rows = read(out)
    assert list(rows[0]) == ["image", "group", "symbol", "score", "known"]
    assert [(row["image"], row["group"]) for row in rows] == [
        (image, group) for image in ("3.png", "17.png") for group in ("shape", "colour")
    ]
    assert [row["symbol"] for row in rows if row["known"] == "1"] == ["cell", "red", "block", "red"]


def test_a_hostile_image_is_one_line_and_stops_nothing(folder: Path, tmp_path: Path):
    out = tmp_path / "out.csv"
    names = [folder / name for name in (*HOSTILE, "none.png", ".", "3.png")]
    result = run("classify", folder / "model.json", "--mm-per-px", 1.0, "--out", out, *names)
    assert result.exit_code == 0
    assert len(result.stderr.splitlines()) == len(HOSTILE) + 2
    known = [row["image"] for row in read(out) if row["known"] == "1"]
    assert known == [str(folder / "3.png")] * 2


def test_only_unreadable_images_is_a_failure(folder: Path):
    assert run("classify", folder / "model.json", folder / "text.jpg").exit_code == 1


def test_a_small_and_a_large_square_are_not_told_apart_without_a_scale(folder: Path):
    result = run("classify", folder / "model.json", folder / "3.png")
    rows = list(csv.DictReader(result.stdout.splitlines()))
    assert {row["group"]: row["known"] for row in rows} == {"colour": "1", "shape": "0"}


def test_a_question_is_answered_by_teaching_and_taken_back_by_undo(folder: Path, tmp_path: Path):
    model = tmp_path / "model.json"
    model.write_bytes((folder / "model.json").read_bytes())
    greens = [draw(tmp_path / f"{n}.png", "green", Shape.CUBE, 900 + n) for n in range(4)]
    asked = run("classify", model, "--mm-per-px", 1.0, greens[3])
    assert "which colour is this" in asked.stderr
    assert run("teach", model, "green", *greens[:3], "--mm-per-px", 1.0).exit_code == 0
    assert ",green," in run("classify", model, "--mm-per-px", 1.0, greens[3]).stdout
    assert run("teach", model, "emerald", "--same-as", "green", "--person", "ann").exit_code == 0
    assert '"emerald": "green"' in run("show", model, "--lexicon", "ann").stdout
    assert run("teach", model, "--undo").exit_code == 0
    assert "green" not in run("teach", model, "--undo").stdout


def test_each_word_has_a_picture(folder: Path, tmp_path: Path):
    shown = run("show", folder / "model.json", "--out", tmp_path / "pictures", "--dropped")
    assert shown.exit_code == 0
    assert "patch,segment,symbol,reason" in shown.stdout
    picture = cv2.imread(str(tmp_path / "pictures/red.png"))
    assert picture is not None
    assert picture.std() > 5


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("picture,symbols\n", "image"),
        ("image,symbols,mm_per_px\na.png,red,-3\n", "line 2"),
        ("image,symbols\nmissing.png,red\n", "no patch"),
        ("\x00\xff", "image"),
    ],
)
def test_labels_that_cannot_be_used_are_named(tmp_path: Path, text: str, word: str):
    labels = tmp_path / "labels.csv"
    labels.write_bytes(text.encode("latin-1"))
    with pytest.raises(InputError, match=word):
        run("fit", labels, "--out", tmp_path / "model.json")


def test_wrong_usage_is_told_from_bad_input(folder: Path):
    assert run("classify", folder / "model.json").exit_code == 2
    assert run("teach", folder / "model.json").exit_code == 2
    assert run("fit", folder / "labels.csv").exit_code == 2
