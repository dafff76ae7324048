"""A thing seen from a moving camera, as if from straight above: pictures that can be compared."""

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from grounding.patches.view import PosedCamera
from grounding.types import FloatArray, ImageArray

_SIDE_PX: Final = 96


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LevelCrop:
    """A square of the level plane through a thing's top, north up.

    Attributes:
        image_bgr: (96, 96, 3).
        mm_per_px: its scale, if the world's is metric.
    """

    image_bgr: ImageArray
    mm_per_px: float


def level_crop(
    camera: PosedCamera, image_bgr: ImageArray, *, top_world: FloatArray, half_m: float
) -> LevelCrop | None:
    """Return the square around a thing's top as seen from above, or None if it is not all seen.

    What stands higher or lower than the plane leans away from or towards the camera.

    Args:
        camera: as it stood.
        image_bgr: (H, W, 3) its image.
        top_world: (3,) the middle of the thing's top.
        half_m: half the square's side.
    """
    steps = (np.arange(_SIDE_PX) + 0.5) / _SIDE_PX * 2 - 1
    x, y = np.meshgrid(steps, -steps)
    points = top_world + half_m * np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    uv = camera.project(points)
    height, width = image_bgr.shape[:2]
    if not np.isfinite(uv).all() or (uv < 0).any() or (uv > [width - 1, height - 1]).any():
        return None
    where = uv.reshape(_SIDE_PX, _SIDE_PX, 2).astype(np.float32)
    seen = cv2.remap(image_bgr, where[..., 0], where[..., 1], cv2.INTER_LINEAR)
    return LevelCrop(image_bgr=np.asarray(seen, dtype=np.uint8), mm_per_px=2e3 * half_m / _SIDE_PX)
