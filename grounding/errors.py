"""Every error that grounding raises on purpose.

    GroundingError              what the user reads is one line: what, where, what to do
    ├── InputError              a sentence file, patch, model or message that cannot be used
    ├── ConfigError             a setting is unknown or out of its range
    ├── BackendError            a parser died, timed out or answered garbage
    └── ConventionError         a caller broke a convention of shapes, units or frames

Expected absence (no referent, an unknown word, no instruction in a sentence) is a value.
"""

from pathlib import Path


class GroundingError(Exception):
    """Base of all errors that are raised on purpose."""


class InputError(GroundingError):
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


class ConfigError(GroundingError):
    """A setting that is unknown or out of its range."""


class BackendError(GroundingError):
    """A parser backend that died, timed out or answered garbage."""


class ConventionError(GroundingError):
    """A caller broke a convention of shapes, units or frames: a bug, not bad input."""
