"""One image of one camera."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gazemap.geometry.arrays import ImageArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Frame:
    """An image as recorded.

    Attributes:
        index: position in the recording, from 0.
        t_ns: exposure of the middle row.
        image: (height, width) grey or (height, width, 3) BGR, on the distorted image.
    """

    index: int
    t_ns: int
    image: ImageArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DepthFrame:
    """A depth image registered to its camera's frames.

    Attributes:
        t_ns: its time.
        depth_m: (height, width) float32 along the optical axis; NaN where it was not measured.
    """

    t_ns: int
    depth_m: NDArray[np.float32]
