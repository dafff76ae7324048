"""The REST backend: a DELPH-IN web service that the user names."""

from collections.abc import Sequence
from typing import Final

from delphin.eds import EDS, from_mrs
from delphin.exceptions import PyDelphinException
from delphin.interface import Result

from grounding.errors import BackendError, ConfigError
from grounding.language.config import LanguageConfig

_READINGS: Final = 5
_UNREADABLE: Final = (PyDelphinException, ValueError, KeyError, TypeError, AttributeError)


class Rest:
    """Parses at a server; each sentence is one request."""

    def __init__(self, config: LanguageConfig) -> None:
        if not config.server.startswith(("http://", "https://")):
            raise ConfigError(
                f'backend rest: "{config.server}" is no address; name a server, for example '
                "--server http://localhost:8080/erg/"
            )
        self._server = config.server if config.server.endswith("/") else config.server + "/"

    @property
    def name(self) -> str:
        """What a parse says it came from."""
        return "rest"

    def readings(self, sentence: str) -> Sequence[EDS]:
        """Return the readings of a sentence, the server's best first.

        Raises:
            BackendError: if the server cannot be reached or answers garbage.
        """
        from delphin.web.client import Parser  # noqa: PLC0415 - brings a network client
        from httpx import HTTPError, HTTPStatusError, InvalidURL  # noqa: PLC0415

        params = {"eds": "json", "mrs": "json", "results": _READINGS}
        try:
            response = Parser(self._server).interact(sentence, params=params)
            return [_eds(result) for result in response.results()]
        except HTTPStatusError as error:
            status = error.response.status_code
            raise BackendError(f"{self._server}: answered with status {status}") from error
        except (HTTPError, InvalidURL) as error:
            reason = str(error) or type(error).__name__
            raise BackendError(f"{self._server}: no answer: {reason}") from error
        except _UNREADABLE as error:
            raise BackendError(f"{self._server}: an answer that cannot be read: {error}") from error


def _eds(result: Result) -> EDS:
    """Return the EDS of a result, made from its MRS where the server sends none."""
    found = result.eds()
    return found if found is not None else from_mrs(result.mrs(), predicate_modifiers=True)
