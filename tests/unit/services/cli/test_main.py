import importlib
import subprocess
import sys

import click
import pytest

from services.cli.main import COMMANDS, cli, main


def run(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "services.cli", *arguments],
        capture_output=True,
        text=True,
        timeout=60,
    )


@pytest.mark.parametrize("name", sorted(COMMANDS))
def test_every_command_is_there_and_has_help(name):
    command = importlib.import_module(COMMANDS[name][0]).command
    assert isinstance(command, click.Command)
    assert command.help or command.callback.__doc__


def test_help_loads_nothing_heavy():
    code = (
        "import sys; sys.argv = ['gazemap', '--help']\n"
        "from services.cli.main import main\n"
        "try: main()\n"
        "finally: print(sorted({'numpy', 'cv2', 'zenoh', 'rich', 'scipy'} & set(sys.modules)))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0
    assert done.stdout.rstrip().endswith("[]")


def test_wrong_usage_exits_with_2():
    assert run("no-such-command").returncode == 2
    assert run("bench", "no-such-bench").returncode == 2


def test_bad_input_is_one_line_and_exit_1(tmp_path):
    done = run("router", "--config", str(tmp_path / "none.json5"))
    assert done.returncode == 1
    assert len(done.stderr.strip().splitlines()) == 1
    assert "none.json5" in done.stderr


def fail():
    raise ZeroDivisionError("by\nnothing")


def test_what_nobody_foresaw_is_one_line_too(monkeypatch, capsys):
    monkeypatch.setattr(cli, "main", lambda **_: fail())
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 1
    err = capsys.readouterr().err
    assert "unexpected ZeroDivisionError: by nothing; run it with GAZEMAP_TRACEBACK=1" in err
    assert err.count("\n") == 1
    monkeypatch.setenv("GAZEMAP_TRACEBACK", "1")
    with pytest.raises(ZeroDivisionError):
        main()
