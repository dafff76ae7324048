"""The scene video as grey frames that can be walked through more than once."""

from collections.abc import Iterator

from gazemap.geometry.arrays import ImageArray
from gazemap.ports import Session
from gazemap.slam.grey import to_grey


class GreyVideo:
    """Grey frames of a session; those that fit into the budget are decoded only once."""

    def __init__(self, session: Session, *, memory_bytes: int) -> None:
        """Take the session; nothing is decoded yet."""
        self._session = session
        self._budget = memory_bytes
        self._kept: list[ImageArray] = []

    def __len__(self) -> int:
        return len(self._session.scene_t_ns)

    def first_pass(self) -> Iterator[tuple[int, ImageArray, ImageArray]]:
        """Yield each frame's index, its grey image and the image as recorded."""
        self._kept.clear()
        kept_bytes = 0
        for frame in self._session.scene_frames():
            grey = to_grey(frame.image)
            if kept_bytes + grey.nbytes <= self._budget and len(self._kept) == frame.index:
                self._kept.append(grey)
                kept_bytes += grey.nbytes
            yield frame.index, grey, frame.image

    def __iter__(self) -> Iterator[tuple[int, ImageArray]]:
        """Yield each frame's index and grey image again."""
        yield from enumerate(self._kept)
        if len(self._kept) < len(self):
            for frame in self._session.scene_frames():
                if frame.index >= len(self._kept):
                    yield frame.index, to_grey(frame.image)
