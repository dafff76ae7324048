"""Every error that gazemap raises on purpose.

    GazemapError                what the user reads is one line: what, where, what to do
    ├── InputError              a file or message is missing, damaged or contradicts another
    ├── ConfigError             a setting is unknown or out of its range
    ├── ConventionError         a caller broke a convention of shapes, units or frames
    └── SolverError             an optimisation was singular or diverged; the state before is kept

Expected absence (a lost track, gaze off the map) is a value, never one of these.
"""

from pathlib import Path


class GazemapError(Exception):
    """Base of all errors that are raised on purpose."""


class InputError(GazemapError):
    """A file or message that cannot be used, said in one line."""

    def __init__(self, what: str, *, where: Path | str, todo: str) -> None:
        """Compose the line.

        Args:
            what: what is wrong, with what was expected and what was found.
            where: the file, stream or row it is wrong in.
            todo: what the user can do about it.
        """
        self.what, self.where, self.todo = what, str(where), todo
        super().__init__(f"{self.where}: {what}; {todo}")


class ConfigError(GazemapError):
    """A setting that is unknown or out of its range."""


class ConventionError(GazemapError):
    """A caller broke a convention of shapes, units or frames: a bug, not bad input."""


class SolverError(GazemapError):
    """An optimisation was singular or diverged; the caller keeps the state from before."""
