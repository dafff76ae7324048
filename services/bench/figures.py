"""One measured figure and the clock it is measured with."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """A measurement, and the same of a peer in the same run where there is one.

    Attributes:
        name: what was measured.
        value: the figure of ours.
        unit: its unit.
        peer: what it is compared with; empty for none.
        peer_value: the peer's figure, in the same unit.
    """

    name: str
    value: float
    unit: str
    peer: str = ""
    peer_value: float | None = None

    @property
    def ratio(self) -> float | None:
        """Ours over the peer's, or None without a peer."""
        return None if not self.peer_value else self.value / self.peer_value


def median_ms(work: Callable[[], object], *, repeats: int) -> float:
    """Return the median CPU time of this process for one call, in milliseconds."""
    times = []
    for _ in range(repeats):
        start = time.process_time_ns()
        work()
        times.append(time.process_time_ns() - start)
    return float(np.median(times)) / 1e6
