import pytest

from gazemap.errors import InputError
from gazemap.session.narration import read_narration


def read(tmp_path, text, *, zero_ns=0):
    path = tmp_path / "narration.vtt"
    path.write_text(text)
    return read_narration(path, zero_ns=zero_ns)


def test_cues_count_from_the_first_frame_and_lose_their_markup(tmp_path):
    text = (
        "WEBVTT - a title\nKind: captions\n\n"
        "NOTES of the first\n00:01.500 --> 00:02.250\npick up the\nred cube\n\n"
        "NOTE\n00:03.000 --> 00:04.000\n\n"
        "01:00:00.001 --> 01:00:01.000 align:start\n<v Ann>put it <b>there</b> &amp; stop\n"
    )
    first, second = read(tmp_path, text, zero_ns=7)
    assert (first.start_ns, first.end_ns) == (1_500_000_007, 2_250_000_007)
    assert first.text == "pick up the red cube"
    assert second.start_ns == 3_600_001_000_007
    assert second.text == "put it there & stop"


@pytest.mark.parametrize(
    "text",
    [
        "",
        "\n",
        "WEBVTT\n",
        "WEBVTT\n\nNOTE nothing\n",
        "WEBVTT\n\n00:01.000 --> 00:02.000\n<b></b>\n",
    ],
)
def test_an_empty_narration_is_refused(tmp_path, text):
    with pytest.raises(InputError, match="the narration is empty"):
        read(tmp_path, text)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("1\n00:01.000 --> 00:02.000\nhi\n", "not WEBVTT"),
        ("WEBVTT\n\n00:01,000 --> 00:02,000\nhi\n", "line 3"),
        ("WEBVTT\n\na\n00:61.000 --> 00:02.000\nhi\n", "line 4"),
        ("WEBVTT\n\n00:02.000 --> 00:01.000\nhi\n", "ends before it starts"),
        ("WEBVTT\n\n00:02.000 --> 00:03.000\nhi\n\n00:01.000 --> 00:03.000\nho\n", "'ho' starts"),
    ],
)
def test_a_malformed_cue_is_refused(tmp_path, text, said):
    with pytest.raises(InputError, match=said):
        read(tmp_path, text)
