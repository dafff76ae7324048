import numpy as np
import pytest

from gazemap.errors import InputError
from gazemap.session.tag_file import read_tags, write_tags

TAG = "{id: 3, size: 0.06, position: [0.1, 0.2, 0], orientation: [0, 0, 0.70711, 0.70711]}"


def read(tmp_path, text):
    path = tmp_path / "tags.yaml"
    path.write_text(text)
    return read_tags(path)


def test_a_tag_has_its_place_and_turn(tmp_path):
    layout = read(tmp_path, f"family: tag36h11\nframe: world\ntags: [{TAG}]\nextra: 1\n")
    (tag,) = layout.tags
    assert (layout.family, tag.tag_id, tag.size_m) == ("tag36h11", 3, 0.06)
    # A quarter turn about z: the printed right edge looks along +y.
    np.testing.assert_allclose(
        tag.T_world_tag.transform(np.array([1.0, 0, 0])), [0.1, 1.2, 0], atol=1e-9
    )


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (f"family: tag99h9\ntags: [{TAG}]", "tag family 'tag99h9' is unknown"),
        (f"tags: [{TAG}]", "tag family 'None' is unknown"),
        ("family: tag36h11", "at least one tag"),
        (f"family: tag36h11\nframe: table\ntags: [{TAG}]", "'frame' is 'table'"),
        (f"family: tag36h11\ntags: [{TAG}, {TAG}]", "used twice"),
        (f"family: tag16h5\ntags: [{TAG.replace('id: 3', 'id: 30')}]", "has no id 30"),
        (f"family: tag36h11\ntags: [{TAG.replace('0.06', '0')}]", "tag 1: 'size'"),
        (f"family: tag36h11\ntags: [{TAG.replace('0.1, ', '')}]", "'position' has 3"),
        (f"family: tag36h11\ntags: [{TAG.replace('0.70711', '0.9')}]", "unit quaternion"),
        (f"family: tag36h11\ntags: [{TAG.replace('size', 'side')}]", "'size' is missing"),
        ("family: [", "no YAML"),
        ("- 1", "a mapping expected"),
    ],
)
def test_a_malformed_layout_is_refused(tmp_path, text, said):
    with pytest.raises(InputError, match=said.replace("[", r"\[")):
        read(tmp_path, text)


def test_a_layout_survives_its_file(tmp_path):
    first = tmp_path / "first.yaml"
    first.write_text(
        "family: tag36h11\nframe: world\ntags:\n"
        "- {id: 7, size: 0.05, position: [0.1, -0.2, 0.3], orientation: [0.6, 0, 0, 0.8]}\n"
    )
    layout = read_tags(first)
    write_tags(layout, tmp_path / "again.yaml")
    (again,) = read_tags(tmp_path / "again.yaml").tags
    assert (again.tag_id, again.size_m) == (7, 0.05)
    assert again.T_world_tag.matrix == pytest.approx(layout.tags[0].T_world_tag.matrix, abs=1e-8)
