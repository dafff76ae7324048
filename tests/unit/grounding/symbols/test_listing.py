from pathlib import Path

import pytest

from grounding.errors import InputError
from grounding.symbols.listing import read_labels, read_list


def written(folder: Path, text: str) -> Path:
    path = folder / "labels.csv"
    path.write_text(text)
    return path


def test_further_columns_are_ignored_and_empty_fields_are_unknown(tmp_path: Path):
    text = "image,symbols,segment,mm_per_px,weight,note\na.png,Red cell,s1,,,x\n"
    (row,) = read_labels(written(tmp_path, text))
    assert row.path == tmp_path / "a.png"
    assert row.symbols == ("red", "cell")
    assert (row.segment, row.mm_per_px, row.weight) == ("s1", None, 1.0)


def test_rows_without_a_segment_are_decisions_of_their_own(tmp_path: Path):
    rows = read_labels(written(tmp_path, "image,symbols\na.png,red\nb.png,red\n"))
    assert rows[0].segment != rows[1].segment


def test_a_weight_of_nothing_is_kept(tmp_path: Path):
    (row,) = read_labels(written(tmp_path, "image,symbols,weight\na.png,red,0.0\n"))
    assert row.weight == 0.0


@pytest.mark.parametrize("number", ["0", "-1", "nan", "inf", "wide"])
def test_a_scale_that_is_none_is_named_with_its_line(tmp_path: Path, number: str):
    path = written(tmp_path, f"image,mm_per_px\na.png,1.0\nb.png,{number}\n")
    with pytest.raises(InputError, match="line 3"):
        read_list(path)


def test_a_file_with_a_byte_order_mark_is_read(tmp_path: Path):
    path = tmp_path / "list.csv"
    path.write_bytes(b"\xef\xbb\xbfimage\na.png\n")
    assert [row.name for row in read_list(path)] == ["a.png"]
