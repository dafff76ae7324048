"""ACE's protocol, spoken by a real process from recorded answers."""

import json
import os
import shutil
import sys
import time
from pathlib import Path

import pytest

from grounding.errors import BackendError, ConfigError
from grounding.language.backends.ace import GRAMMAR_VARIABLE, Ace, installed
from grounding.language.config import BackendChoice, LanguageConfig
from grounding.language.parser import Parser, parser_for
from tests.plans import written

STAND_IN = Path(__file__).parents[4] / "recorded_ace.py"
TAKE = (
    "[ TOP: h0 INDEX: e2 [ e SF: comm TENSE: pres MOOD: indicative PROG: - PERF: - ] RELS: < "
    "[ pronoun_q<0:12> LBL: h4 ARG0: x3 [ x PERS: 2 PT: zero ] RSTR: h5 BODY: h6 ] "
    "[ pron<0:12> LBL: h7 ARG0: x3 ] [ _take_v_1<0:4> LBL: h1 ARG0: e2 ARG1: x3 ARG2: x8 "
    "[ x PERS: 3 NUM: sg IND: + ] ] [ _the_q<5:8> LBL: h9 ARG0: x8 RSTR: h10 BODY: h11 ] "
    "[ _cup_n_1<9:12> LBL: h12 ARG0: x8 ] > HCONS: < h0 qeq h1 h5 qeq h7 h10 qeq h12 > ]"
)
FRAGMENT = (
    "[ TOP: h0 INDEX: e2 [ e SF: prop-or-ques ] RELS: < [ unknown<0:12> LBL: h1 ARG: x4 ARG0: e2 ] "
    "[ _the_q<5:8> LBL: h5 ARG0: x4 RSTR: h6 BODY: h7 ] [ _cup_n_1<9:12> LBL: h8 ARG0: x4 ] > "
    "HCONS: < h0 qeq h1 h6 qeq h8 > ]"
)
ANSWERS = {
    "take the cup": [TAKE],
    "take a cup": [FRAGMENT, TAKE],
    "die now": "die",
    "hang now": "hang",
    "speak garbage": "garbage",
}


@pytest.fixture
def config(tmp_path):
    """Return a configuration that names the stand-in and its answers."""
    grammar = tmp_path / "erg.dat"
    grammar.write_text(json.dumps(ANSWERS))
    program = tmp_path / "ace"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{STAND_IN}" "$@"\n')
    program.chmod(0o755)
    return LanguageConfig(
        backend=BackendChoice.ACE, ace=program, grammar=grammar, timeout_s=1.0, memory_mb=100
    )


@pytest.fixture
def ace(config):
    """Return the backend; its process is ended afterwards."""
    found = installed(config)
    assert found is not None
    backend = Ace(found, config)
    yield backend
    backend.close()


def test_an_answer_becomes_readings(ace):
    (eds,) = ace.readings("take the  cup\n")
    assert eds.top == "e2"
    assert {"_take_v_1", "_the_q", "_cup_n_1"} <= {node.predicate for node in eds.nodes}


def test_the_best_reading_that_commands_something_is_used(ace):
    result = Parser(ace).parse("take a cup")
    assert result.backend == "ace"
    assert written(result.instructions) == "pick cup"
    assert len(result.parses[0].readings) == 2


def test_a_sentence_without_an_analysis_has_no_reading(ace):
    assert ace.readings("colourless green ideas") == []


@pytest.mark.parametrize(
    ("sentence", "message"),
    [("die now", "died"), ("hang now", "more than 1 s"), ("speak garbage", "cannot be read")],
)
def test_a_failure_is_told_once_and_survived(ace, sentence, message):
    start = time.monotonic()
    with pytest.raises(BackendError, match=message):
        ace.readings(sentence)
    assert time.monotonic() - start < 10
    assert len(ace.readings("take the cup")) == 1


def test_a_failure_in_a_discourse_costs_its_sentence_only(ace):
    results = Parser(ace).parse_discourse(["take the cup", "die now", "take the cup"])
    assert [written(each.instructions) for each in results] == ["pick cup", "", "pick cup"]
    assert "\n" not in str(results[1].error)


def test_a_program_that_is_no_ace_is_told(config, tmp_path):
    program = tmp_path / "no-ace"
    program.write_text("#!/bin/sh\nexit 3\n")
    program.chmod(0o755)
    found = installed(LanguageConfig(ace=program, grammar=config.grammar))
    assert found is not None
    with pytest.raises(BackendError, match="cannot be started"):
        Ace(found, config).readings("take the cup")


def test_ace_is_found_by_configuration_and_by_the_path(config, monkeypatch):
    monkeypatch.delenv(GRAMMAR_VARIABLE, raising=False)
    assert installed(config) is not None
    assert installed(LanguageConfig(ace=config.ace)) is None
    monkeypatch.setenv("PATH", f"{config.ace.parent}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv(GRAMMAR_VARIABLE, str(config.grammar))
    found = installed(LanguageConfig())
    assert found is not None
    assert found.executable == config.ace


def test_a_missing_ace_says_what_to_do(tmp_path):
    config = LanguageConfig(backend=BackendChoice.ACE, ace=tmp_path / "absent")
    with pytest.raises(ConfigError, match="doctor"):
        parser_for(config)


@pytest.mark.skipif(
    shutil.which("ace") is None or GRAMMAR_VARIABLE not in os.environ,
    reason="ace is not on the path, or GAZEMAP_ERG names no grammar",
)
def test_the_installed_ace_parses():
    parser = parser_for(LanguageConfig(backend=BackendChoice.ACE))
    assert written(parser.parse("pick up the red cube").instructions) == "pick red-cube"
