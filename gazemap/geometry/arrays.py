"""Array types and the one check that records make of their arrays."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gazemap.errors import ConventionError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
ImageArray = NDArray[np.uint8]


def frozen_floats(
    values: ArrayLike, shape: tuple[int | None, ...], *, name: str, finite: bool = True
) -> FloatArray:
    """Return a read-only float64 copy of the given shape, where None stands for any length.

    Raises:
        ConventionError: if the shape differs, or a value is not finite where `finite` is asked for.
    """
    array = np.array(values, dtype=np.float64)
    check_shape(array, shape, name=name)
    if finite and not np.isfinite(array).all():
        raise ConventionError(f"{name}: finite numbers expected, got {array}")
    array.setflags(write=False)
    return array


def frozen_ints(values: ArrayLike, shape: tuple[int | None, ...], *, name: str) -> IntArray:
    """Return a read-only int64 copy of the given shape, where None stands for any length."""
    array = np.array(values, dtype=np.int64)
    check_shape(array, shape, name=name)
    array.setflags(write=False)
    return array


def check_shape(array: NDArray[Any], shape: tuple[int | None, ...], *, name: str) -> None:
    """Raise ConventionError unless the array has the shape, where None stands for any length."""
    fits = array.ndim == len(shape) and all(
        want in (None, have) for want, have in zip(shape, array.shape, strict=True)
    )
    if not fits:
        raise ConventionError(f"{name}: shape {shape} expected, got {array.shape}")
