"""One image of one camera."""

from dataclasses import dataclass

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
