"""The scene video as grey frames that can be walked through more than once."""

from collections.abc import Iterator

import numpy as np

from gazemap.geometry.arrays import ImageArray
from gazemap.ports import Session
from gazemap.slam.grey import to_grey


class GreyVideo:
    """Grey frames of a session; those that fit into the budget are decoded only once."""

    def __init__(self, session: Session, *, memory_bytes: int) -> None:
        """Take the session; nothing is decoded yet."""
        camera = session.scene_camera
        capacity = min(
            len(session.scene_t_ns), memory_bytes // (camera.width_px * camera.height_px)
        )
        self._session = session
        # One block: frames kept among others that are thrown away would leave memory in shreds.
        self._kept = np.empty((capacity, camera.height_px, camera.width_px), dtype=np.uint8)
        self._kept_count = 0

    def __len__(self) -> int:
        return len(self._session.scene_t_ns)

    def first_pass(self) -> Iterator[tuple[int, ImageArray, ImageArray]]:
        """Yield each frame's index, its grey image and the image as recorded."""
        self._kept_count = 0
        for frame in self._session.scene_frames():
            grey = to_grey(frame.image)
            if frame.index == self._kept_count < len(self._kept):
                self._kept[frame.index] = grey
                self._kept_count += 1
            yield frame.index, grey, frame.image

    def __iter__(self) -> Iterator[tuple[int, ImageArray]]:
        """Yield each frame's index and grey image again."""
        yield from enumerate(self._kept[: self._kept_count])
        if self._kept_count < len(self):
            for frame in self._session.scene_frames():
                if frame.index >= self._kept_count:
                    yield frame.index, to_grey(frame.image)
