import json

import pytest
from click.testing import CliRunner
from delphin.codecs import eds as native

from grounding.errors import ConfigError, InputError
from grounding.language.backends.embedded import Embedded
from grounding.language.verbs import default_verbs
from services.cli.parse import command


def run(*arguments, lines=b""):
    done = CliRunner().invoke(command, arguments, input=lines)
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done.exit_code, [json.loads(line) for line in done.stdout.splitlines()]


def test_an_argument_gives_one_object_with_the_promised_keys():
    code, (row,) = run("--backend", "embedded", "pick up the blue cube")
    assert code == 0
    assert row == {
        "sentence": "pick up the blue cube",
        "backend": "embedded",
        "error": None,
        "instructions": [
            {
                "action": "pick",
                "target": ["blue", "cube"],
                "location": "blue-cube-location",
                "target_relation": None,
                "resolved_from": None,
                "unknown": [],
            }
        ],
    }


def test_every_line_gives_one_object_blank_and_broken_ones_too():
    lines = "take the cup\n\n  \nput it down\r\n\u043f\u0440\u2028\u043c\n".encode() + b"\xff\xfe\n"
    code, rows = run("--backend", "embedded", lines=lines)
    assert code == 0
    assert [row["sentence"] for row in rows[:5]] == [
        "take the cup", "", "  ", "put it down", "\u043f\u0440\u2028\u043c",
    ]  # fmt: skip
    assert len(rows) == 6
    assert [row["error"] is None for row in rows] == [True, False, False, False, False, False]


def test_each_line_is_a_discourse_of_its_own():
    _, rows = run("--backend", "embedded", "take the cup. drop it", "drop it")
    assert [len(row["instructions"]) for row in rows] == [2, 0]
    assert rows[0]["instructions"][1]["resolved_from"] == 0


def test_a_verb_can_be_taught_on_the_command_line_and_in_a_file(tmp_path):
    _, (row,) = run("--backend", "embedded", "--verb", "ponder=look", "ponder the cup")
    assert row["instructions"][0]["action"] == "point"
    config = tmp_path / "language.toml"
    config.write_text('backend = "embedded"\n[verbs]\nponder = "push"\n"turn on" = "push"\n')
    _, rows = run("--config", str(config), "ponder the cup", "turn on the lamp")
    assert [row["instructions"][0]["action"] for row in rows] == ["push", "push"]


def test_recorded_readings_are_traversed():
    text = native.encode(Embedded(default_verbs()).readings("take the cup")[0])
    line = json.dumps({"sentence": "take the cup", "eds_native": text})
    code, rows = run("--backend", "eds", lines=f"{line}\n\n".encode())
    assert code == 0
    assert [row["backend"] for row in rows] == ["eds", "eds"]
    assert rows[0]["instructions"][0]["target"] == ["cup"]
    assert rows[1]["error"] is not None


@pytest.mark.parametrize(
    "line", ["no json", "[]", "{}", '{"sentence": 1, "eds_native": 2}', "[" * 100_000,
             '{"sentence": "x", "eds_native": "{e2: e2:_take"}']
)  # fmt: skip
def test_what_is_no_recorded_reading_is_named_by_its_line(line):
    with pytest.raises(InputError, match="line 1"):
        run("--backend", "eds", lines=line.encode())


def test_a_line_that_cannot_be_read_costs_itself_only():
    text = native.encode(Embedded(default_verbs()).readings("take the cup")[0])
    good = json.dumps({"sentence": "take the cup", "eds_native": text, "more": 1})
    done = CliRunner().invoke(command, ["--backend", "eds"], input=f"{good}\nno json\n{good}\n")
    assert isinstance(done.exception, InputError)
    assert "line 2" in str(done.exception)
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    assert [row["sentence"] for row in rows] == ["take the cup", "no json", "take the cup"]
    assert [row["error"] is None for row in rows] == [True, False, True]


def test_an_argument_that_is_no_text_is_read_as_a_line_would_be():
    _, (row,) = run("--backend", "embedded", "take the \udcff")
    assert row["sentence"] == "take the \ufffd"


def test_wrong_usage_and_missing_backends_are_told():
    assert run("--verb", "ponder", "x")[0] == 2
    with pytest.raises(ConfigError, match="no address"):
        run("--backend", "rest", "x")
    with pytest.raises(ConfigError, match="choose one of"):
        run("--verb", "ponder=wonder", "x")
