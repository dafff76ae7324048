"""Which backend a configuration asks for."""

from typing import assert_never

from grounding.language.backends.ace import Ace, found_or_refused, installed
from grounding.language.backends.base import Backend
from grounding.language.backends.embedded import Embedded
from grounding.language.backends.rest import Rest
from grounding.language.config import BackendChoice, LanguageConfig
from grounding.language.verbs import VerbTable


def backend_for(config: LanguageConfig, verbs: VerbTable) -> Backend:
    """Return the backend that is asked for.

    Raises:
        ConfigError: if it is not installed or lacks a setting.
    """
    match config.backend:
        case BackendChoice.EMBEDDED:
            return Embedded(verbs)
        case BackendChoice.REST:
            return Rest(config)
        case BackendChoice.ACE:
            return Ace(found_or_refused(config), config)
        case BackendChoice.AUTO:
            found = installed(config)
            return Embedded(verbs) if found is None else Ace(found, config)
        case other:
            assert_never(other)
