"""Which parser is used, and which verbs a user added."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path


class BackendChoice(StrEnum):
    """The backend to parse with; AUTO is ACE where it is installed, the embedded one otherwise."""

    AUTO = "auto"
    ACE = "ace"
    REST = "rest"
    EMBEDDED = "embedded"


@dataclass(frozen=True, slots=True, kw_only=True)
class LanguageConfig:
    """Settings of the language stage.

    Attributes:
        backend: which parser.
        ace: the program `ace`; None looks for it on the path.
        grammar: the compiled grammar image for it; None takes what GAZEMAP_ERG names.
        server: address of a DELPH-IN web service, for the backend `rest`.
        timeout_s: how long one sentence may take in ACE or at the server.
        memory_mb: how much memory ACE may use for its chart.
        verbs: verbs that were added, each with one of the table that it resembles.
    """

    backend: BackendChoice = BackendChoice.AUTO
    ace: Path | None = None
    grammar: Path | None = None
    server: str = ""
    timeout_s: float = 10.0
    memory_mb: int = 1200
    verbs: Mapping[str, str] = field(default_factory=dict)
