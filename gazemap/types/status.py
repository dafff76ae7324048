"""How a service is, as it says itself."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum


class Level(StrEnum):
    """How well a service, or a stage of a rebuild, does."""

    OK = "ok"
    WARNING = "warning"
    ERROR = "error"


@dataclass(frozen=True, slots=True, kw_only=True)
class ServiceStatus:
    """What a service says about itself.

    Attributes:
        service: its name.
        t_ns: the time that it has come to in the recording or live run.
        level: how it does.
        messages: one line each.
        figures: numbers by name, such as frames seen.
    """

    service: str
    t_ns: int
    level: Level
    messages: tuple[str, ...] = ()
    figures: Mapping[str, float] = field(default_factory=dict)
