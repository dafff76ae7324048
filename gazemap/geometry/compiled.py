"""The one door to numba, so that compiled functions keep their types for mypy."""

from collections.abc import Callable
from typing import ParamSpec, TypeVar

import numba

P = ParamSpec("P")
Out = TypeVar("Out")


def compiled(function: Callable[P, Out]) -> Callable[P, Out]:
    """Compile a function of arrays and numbers on its first call and keep the machine code.

    Neither fastmath nor threads are used: the same input gives the same bits.
    """
    machine_code: Callable[P, Out] = numba.njit(cache=True)(function)
    return machine_code
