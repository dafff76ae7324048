import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from grounding.errors import InputError
from grounding.symbols.document import from_json, to_json
from grounding.symbols.model import SymbolModel
from grounding.symbols.online import forget
from grounding.symbols.store import MAX_VERSIONS, read_model, save_model, undo


def test_undo_goes_back_one_version_at_a_time(tmp_path: Path, model: SymbolModel):
    path = tmp_path / "model.json"
    save_model(path, model)
    save_model(path, forget(model, "red"))
    save_model(path, forget(forget(model, "red"), "cube"))
    assert "cube" in undo(path).words
    assert "red" in undo(path).words
    assert "red" in read_model(path).words
    with pytest.raises(InputError, match="nothing to undo"):
        undo(path)


def test_a_kill_between_the_two_steps_of_a_save_loses_nothing(tmp_path: Path, model: SymbolModel):
    path = tmp_path / "model.json"
    save_model(path, model)
    (tmp_path / "model.json.versions").mkdir()
    os.link(path, tmp_path / "model.json.versions/000001.json")  # then the power failed
    save_model(path, forget(model, "red"))
    assert "red" in undo(path).words


def test_a_kill_while_writing_leaves_the_old_model(tmp_path: Path, model: SymbolModel):
    path = tmp_path / "model.json"
    save_model(path, model)
    (tmp_path / ".model.json.abc").write_text('{"version": 1, "symb')
    assert set(read_model(path).words) == set(model.words)


def test_a_process_killed_at_any_moment_leaves_whole_models(tmp_path: Path, model: SymbolModel):
    path = tmp_path / "model.json"
    save_model(path, model)
    program = (
        "import sys, pathlib; from grounding.symbols.store import read_model, save_model\n"
        "path = pathlib.Path(sys.argv[1]); model = read_model(path); print(flush=True)\n"
        "while True: save_model(path, model)"
    )
    for wait_s in (0.013, 0.041):
        with subprocess.Popen(
            [sys.executable, "-c", program, str(path)], stdout=subprocess.PIPE
        ) as saving:
            assert saving.stdout is not None
            saving.stdout.readline()
            time.sleep(wait_s)  # no clock of ours: the moment of the kill is the subject
            saving.kill()
        versions = (tmp_path / "model.json.versions").glob("*.json")
        for each in (path, *versions):
            assert set(read_model(each).words) == set(model.words)


def test_old_versions_leave(tmp_path: Path, model: SymbolModel):
    path = tmp_path / "model.json"
    small = forget(forget(forget(forget(model, "red"), "blue"), "cube"), "cell")
    for _ in range(MAX_VERSIONS + 4):
        save_model(path, small)
    assert len(list((tmp_path / "model.json.versions").iterdir())) == MAX_VERSIONS


def test_the_document_keeps_what_is_promised(model: SymbolModel):
    document = json.loads(to_json(model))
    assert set(document["groups"]) == {"colour", "shape"}
    red = document["symbols"]["red"]
    assert {"features", "mean", "covariance", "kept", "dropped", "group"} <= set(red)
    assert red["group"] == "colour"
    d = len(red["features"])
    assert (len(red["mean"]), len(red["covariance"]), len(red["covariance"][0])) == (d, d, d)
    lightness = red["mean"][red["features"].index("lightness")]
    assert 30 < lightness < 60


def test_a_model_survives_its_document(model: SymbolModel):
    once = to_json(from_json(to_json(model), where="here"))
    assert once == to_json(from_json(once, where="here"))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        '{"version": 2}',
        '{"version": 1, "symbols": {}, "groups": {}, "state": {}}',
        '{"version": 1, "symbols": 3, "groups": {}, "state": {"config": 4, "features": []}}',
    ],
)
def test_what_is_no_model_is_refused_in_one_line(text: str):
    with pytest.raises(InputError) as caught:
        from_json(text, where="model.json")
    assert "\n" not in str(caught.value)


def test_a_number_out_of_shape_is_refused(model: SymbolModel):
    document = json.loads(to_json(model))
    document["state"]["moments"]["red"]["mean"].pop()
    with pytest.raises(InputError, match="not a model"):
        from_json(json.dumps(document), where="model.json")
