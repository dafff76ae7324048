import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from grounding.errors import InputError
from grounding.features.image import read_patch

PICTURE = np.random.default_rng(0).integers(0, 255, (40, 30, 3), dtype=np.uint8)


def saved(path: Path, image: Image.Image) -> Path:
    image.save(path)
    return path


def test_channels_come_as_bgr(tmp_path: Path):
    patch = read_patch(saved(tmp_path / "a.png", Image.fromarray(PICTURE)))
    assert np.array_equal(patch.bgr, PICTURE[..., ::-1])
    assert patch.note == ""


def test_sixteen_bit_grey_keeps_its_levels(tmp_path: Path):
    deep = PICTURE[..., 0].astype(np.uint16) * 257
    patch = read_patch(saved(tmp_path / "a.png", Image.fromarray(deep)))
    assert np.array_equal(patch.bgr[..., 1], PICTURE[..., 0])
    assert "I;16" in patch.note


def test_alpha_that_cuts_something_out_is_the_mask(tmp_path: Path):
    alpha = np.zeros((40, 30), np.uint8)
    alpha[10:20, 5:25] = 255
    image = Image.fromarray(np.dstack([PICTURE, alpha]))
    patch = read_patch(saved(tmp_path / "a.png", image))
    assert patch.mask is not None
    assert np.array_equal(patch.mask, alpha > 0)


@pytest.mark.parametrize("mode", ["L", "LA", "P", "CMYK", "1"])
def test_other_modes_are_read_as_colour(tmp_path: Path, mode: str):
    name = "a.tif" if mode == "CMYK" else "a.png"
    patch = read_patch(saved(tmp_path / name, Image.fromarray(PICTURE).convert(mode)))
    assert patch.bgr.shape == (40, 30, 3)
    assert mode in patch.note


def truncated(path: Path) -> None:
    Image.fromarray(PICTURE).save(path)
    path.write_bytes(path.read_bytes()[:400])


def text(path: Path) -> None:
    path.write_text("hello")


def empty(path: Path) -> None:
    path.write_bytes(b"")


def wide(path: Path) -> None:
    Image.new("RGB", (20_000, 4)).save(path)


@pytest.mark.parametrize(
    ("spoil", "word"),
    [(truncated, "damaged"), (text, "not an image"), (empty, "not an image"), (wide, "20000")],
)
def test_what_cannot_be_read_is_said_in_one_line(tmp_path: Path, spoil, word: str):
    path = tmp_path / "a.png"
    spoil(path)
    with pytest.raises(InputError, match=word) as caught:
        read_patch(path)
    assert "\n" not in str(caught.value)


def test_a_file_that_is_not_there_is_named(tmp_path: Path):
    with pytest.raises(InputError, match="no such file"):
        read_patch(tmp_path / "none.png")


def test_a_folder_is_no_image(tmp_path: Path):
    with pytest.raises(InputError, match="a folder"):
        read_patch(tmp_path)


def test_a_pipe_is_refused_and_not_waited_for(tmp_path: Path):
    os.mkfifo(tmp_path / "pipe.png")
    with pytest.raises(InputError, match="a pipe"):
        read_patch(tmp_path / "pipe.png")
