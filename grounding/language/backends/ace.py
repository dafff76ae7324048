"""The ACE backend: the English Resource Grammar in a process beside ours."""

import contextlib
import os
import shutil
import subprocess
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from delphin.eds import EDS, from_mrs
from delphin.exceptions import PyDelphinException
from delphin.interface import Response

from grounding.errors import BackendError, ConfigError
from grounding.language.config import LanguageConfig

GRAMMAR_VARIABLE: Final = "GAZEMAP_ERG"
_READINGS: Final = 5
_START_S: Final = 10.0
# Beyond ACE's own limit: a parser that does not keep it is ended.
_GRACE_S: Final = 2.0
_DIED: Final = "ace died on this sentence and is started again for the next"
_UNREADABLE: Final = (
    PyDelphinException, ValueError, IndexError, KeyError, TypeError, AttributeError, AssertionError,
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Installation:
    """Where ACE and its grammar are."""

    executable: Path
    grammar: Path


def installed(config: LanguageConfig) -> Installation | None:
    """Return where ACE and its grammar are, or None where either is missing."""
    found = str(config.ace) if config.ace is not None else shutil.which("ace")
    named = config.grammar or os.environ.get(GRAMMAR_VARIABLE)
    if not found or not named or not Path(named).is_file() or shutil.which(found) is None:
        return None
    return Installation(executable=Path(found), grammar=Path(named))


class Ace:
    """Parses with ACE; its process is started at the first sentence and again when it dies."""

    def __init__(self, installation: Installation, config: LanguageConfig) -> None:
        self._installation = installation
        self._config = config
        self._process: Any = None

    @property
    def name(self) -> str:
        """What a parse says it came from."""
        return "ace"

    def readings(self, sentence: str) -> Sequence[EDS]:
        """Return the readings of a sentence, the grammar's best first.

        Raises:
            BackendError: if ACE cannot be started, died, ran out of time or answered garbage; the
                next sentence gets a new process.
        """
        text = " ".join(sentence.split())
        process = self._process or self._started()
        late = threading.Event()
        limit = threading.Timer(self._config.timeout_s + _GRACE_S, _end, (process, late))
        limit.daemon = True
        limit.start()
        try:
            return _answer(process, text)
        except (*_UNREADABLE, OSError, BackendError) as error:
            self.close()
            what = _DIED if process.is_dead else f"ace answered what cannot be read: {error}"
            raise BackendError(self._late if late.is_set() else what) from error
        finally:
            limit.cancel()

    def close(self) -> None:
        """End the process, if there is one."""
        process, self._process = self._process, None
        if process is not None:
            process.end()

    @property
    def _late(self) -> str:
        return f"ace took more than {self._config.timeout_s:g} s for this sentence"

    def _started(self) -> Any:  # noqa: ANN401 - the class is made when ACE is first wanted
        executable = str(self._installation.executable)
        try:
            subprocess.run(  # noqa: S603 - the program that the user named
                [executable, "-V"], capture_output=True, check=True, timeout=_START_S
            )
            self._process = _process_class()(
                str(self._installation.grammar), cmdargs=self._arguments(), executable=executable,
                stderr=subprocess.DEVNULL,
            )  # fmt: skip
        except (OSError, ValueError, subprocess.SubprocessError, PyDelphinException) as error:
            raise BackendError(f"{executable} cannot be started: {error}") from error
        return self._process

    def _arguments(self) -> list[str]:
        memory = str(self._config.memory_mb)
        return [
            "-n", str(_READINGS), "--timeout", str(max(1, round(self._config.timeout_s))),
            "--max-chart-megabytes", memory, "--max-unpack-megabytes", memory,
        ]  # fmt: skip


def found_or_refused(config: LanguageConfig) -> Installation:
    """Return where ACE is.

    Raises:
        ConfigError: if it or its grammar is missing.
    """
    found = installed(config)
    if found is None:
        raise ConfigError(
            f"backend ace: put `ace` on the path and name its grammar in {GRAMMAR_VARIABLE}, or "
            "use --backend embedded; `gazemap doctor` says how to install them"
        )
    return found


def _end(process: Any, late: threading.Event) -> None:  # noqa: ANN401 - see _process_class
    late.set()
    process.end()


def _answer(process: Any, text: str) -> list[EDS]:  # noqa: ANN401 - see _process_class
    response: Response = process.interact(text)
    if _is_silent(response):
        process.is_dead = True
        raise BackendError(_DIED)
    return [_eds(result.mrs()) for result in response.results()]


def _is_silent(response: Response) -> bool:
    """Whether nothing at all was said: ACE notes something even about a sentence it rejects."""
    return not (response.results() or response["NOTES"] or response["ERRORS"]) and (
        "ninputs" not in response
    )


def _eds(mrs: Any) -> EDS:  # noqa: ANN401 - PyDelphin's types are not known to mypy
    return from_mrs(mrs, predicate_modifiers=True)


def _process_class() -> type[Any]:
    """Return PyDelphin's client, told to stay dead and to end its process.

    It is imported here because importing it sets the locale of our process.
    """
    from delphin.ace import ACEParser, ACEProcessError  # noqa: PLC0415

    class Process(ACEParser):  # type: ignore[misc] # untyped
        """ACE's process; one that died is not opened again here, but by who asks next."""

        is_open = False
        is_dead = False

        def _open(self) -> None:
            if self.is_open:
                self.is_dead = True
                raise ACEProcessError(_DIED)
            super()._open()
            self.is_open = True

        def end(self) -> None:
            """Kill the process and release its pipes."""
            self._p.kill()
            self._p.wait()
            for pipe in (self._p.stdin, self._p.stdout):
                with contextlib.suppress(OSError):
                    pipe.close()

    return Process
