import pytest

from services.rebuild.stages import Outcome, Stages, Status, input_key


@pytest.fixture
def calls():
    return []


def work(calls, value, messages=()):
    def run():
        calls.append(value)
        return Outcome(result=value, messages=messages)

    return run


def test_a_finished_stage_is_not_run_again_and_keeps_its_report(tmp_path, calls):
    for _ in range(2):
        stages = Stages(folder=tmp_path, key="k")
        assert stages.run("map", work(calls, 1, ("no tags seen",))) == 1
    assert calls == [1]
    assert stages.reports["map"].status is Status.WARNING
    assert stages.reports["map"].messages == ("no tags seen",)


def test_another_option_redoes_its_stage_and_all_after_it(tmp_path, calls):
    for option in ("auto", "off"):
        stages = Stages(folder=tmp_path, key="k")
        stages.run("map", work(calls, "map"))
        stages.run("gaze", work(calls, "gaze"), options=option)
        stages.run("plan", work(calls, "plan"))
    assert calls == ["map", "gaze", "plan", "gaze", "plan"]


def test_a_stage_that_fails_leaves_those_before_it_finished(tmp_path, calls):
    stages = Stages(folder=tmp_path, key="k")
    stages.run("map", work(calls, "map"))
    with pytest.raises(ZeroDivisionError):
        stages.run("gaze", lambda: Outcome(result=1 // 0))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["map"]


def test_a_half_written_stage_is_redone(tmp_path, calls):
    Stages(folder=tmp_path, key="k").run("map", work(calls, "map"))
    (tmp_path / "map" / "stage.json").write_text('{"key": ')
    Stages(folder=tmp_path, key="k").run("map", work(calls, "map"))
    assert calls == ["map", "map"]


def test_the_input_key_follows_the_files(tmp_path):
    (tmp_path / "a.csv").write_text("1")
    before = input_key(tmp_path)
    assert input_key(tmp_path) == before
    (tmp_path / "a.csv").write_text("12")
    assert input_key(tmp_path) != before
