"""What a backend is."""

from collections.abc import Sequence
from typing import Protocol

from delphin.eds import EDS


class Backend(Protocol):
    """Turns a sentence into its readings."""

    @property
    def name(self) -> str:
        """What a parse says it came from."""

    def readings(self, sentence: str) -> Sequence[EDS]:
        """Return the readings of a sentence, the best first; none if there is no analysis.

        Raises:
            BackendError: if the parser behind it died, timed out or answered garbage.
        """
