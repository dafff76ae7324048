"""The console script `gazemap`: finds a command, runs it, and says in one line what went wrong."""

import importlib
import io
import os
import sys
from typing import Final, NoReturn

import click
from typing_extensions import override

# Commands are imported when they are called: `gazemap --help` answers at once.
COMMANDS: Final[dict[str, tuple[str, str]]] = {
    "bench": ("services.cli.bench", "Measure speed and memory beside a peer."),
    "doctor": ("services.cli.doctor", "Say what is installed, what is missing, and what to do."),
    "import": ("services.cli.import_", "Turn a recording of another format into the native one."),
    "parse": ("services.cli.parse", "Turn sentences into instructions."),
    "replay": ("services.cli.replay", "Publish a recording as a rig would."),
    "router": ("services.cli.router", "Run a Zenoh router with the rules of deploy/."),
    "simulate": ("services.cli.simulate", "Write a simulated session and the truth about it."),
    "symbols": ("services.cli.symbols", "Learn what words mean from patches, and name new ones."),
    "slam": ("services.cli.slam", "Track and map a recording."),
    "rebuild": ("services.cli.rebuild", "Rebuild sessions offline, better than live."),
    "serve": ("services.cli.serve", "Run the mapping or the grounding service."),
    "demo": ("services.cli.demo", "Simulate, ground it live over loopback, rebuild it."),
}

_SHOWS_TRACES: Final = "GAZEMAP_TRACEBACK"


class LazyGroup(click.Group):
    """A group that imports a command's module only when the command is called."""

    @override
    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted(COMMANDS)

    @override
    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = importlib.import_module(COMMANDS[cmd_name][0]).command
        return command

    @override
    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, COMMANDS[name][1]) for name in sorted(COMMANDS)])


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="gazemap")
def cli() -> None:
    """Learn what a person means from what they say and where they look."""


def main() -> None:
    """Run the console script: 0 on success, 2 on wrong usage, 1 with one line otherwise."""
    from services.children import stop_with_parent

    stop_with_parent()
    if isinstance(sys.stdout, io.TextIOWrapper):
        # What is said as it happens is read as it happens, through a pipe too.
        sys.stdout.reconfigure(line_buffering=True)
    try:
        cli.main(standalone_mode=False)
    except click.exceptions.Abort:
        sys.exit(1)
    except click.ClickException as error:
        error.show()
        sys.exit(error.exit_code)
    except BrokenPipeError:
        # Who read our output has left, as `head` does: nobody is there to be told.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except Exception as error:
        line = _line_of(error)
        if line is None and _SHOWS_TRACES in os.environ:
            raise
        _say(line or _last_resort(error))


def _line_of(error: Exception) -> str | None:
    """Return what an error that was foreseen says; None for one that was not."""
    from gazemap.errors import GazemapError
    from grounding.errors import GroundingError

    if isinstance(error, GazemapError | GroundingError):
        return str(error)
    if isinstance(error, OSError):
        what = error.strerror or error
        return f"{error.filename or 'a file'}: {what}; check the path, its rights and space"
    return None


def _last_resort(error: Exception) -> str:
    what = f"{type(error).__name__}: {error}"
    return f"unexpected {what:.300}; run it with {_SHOWS_TRACES}=1 and report what it says"


def _say(line: str) -> NoReturn:
    """Say what was wrong in one line, and leave."""
    print("gazemap: " + " ".join(line.split()), file=sys.stderr)
    sys.exit(1)
