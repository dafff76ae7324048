"""A text as sentences."""

import re
from typing import Final

_STOPS: Final = ".!?…\u3002\uff01\uff1f"  # the last three are the full-width ones
_END: Final = re.compile(rf"(?<=[{_STOPS}])(?<!\d\.(?=\d))\s*|[\r\n\v\f\u2028\u2029]+")


def sentences_of(text: str) -> list[str]:
    """Return the sentences of a text, without the white space around them; none is empty."""
    return [part.strip() for part in _END.split(text) if part.strip(" \t" + _STOPS)]
