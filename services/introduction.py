"""What a rig says of itself when it begins: its cameras and its tags."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from gazemap.calibration.rig import Rig
from gazemap.errors import InputError
from gazemap.geometry.camera import Camera
from gazemap.session.tag_file import FAMILIES
from gazemap.types.session import TagLayout
from gazemap.wire import images, rig
from gazemap.wire.streams import Stream

# The streams of one beginning do not arrive in the order in which they were sent.
_TOGETHER_S: Final = 1.0
INTRODUCTION: Final = (Stream.TAGS, Stream.HEAD_CALIBRATION, Stream.OVERHEAD_CALIBRATION)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Told:
    payload: bytes
    heard_s: float


class Introduction:
    """The rig as it was told, over what is known of it from its calibration."""

    def __init__(
        self, known: Rig | None = None, *, now_s: Callable[[], float] = time.monotonic
    ) -> None:
        self._known, self._now_s = known, now_s
        self._told: dict[Stream, _Told] = {}
        self._cameras: dict[Stream, Camera] = {}
        self._layout: TagLayout | None = None

    @property
    def head(self) -> Camera | None:
        """The head camera."""
        known = self._known.head_camera if self._known else None
        return self._cameras.get(Stream.HEAD_CALIBRATION, known)

    @property
    def overhead(self) -> Camera | None:
        """The overhead camera."""
        known = self._known.overhead_camera if self._known else None
        return self._cameras.get(Stream.OVERHEAD_CALIBRATION, known)

    @property
    def layout(self) -> TagLayout | None:
        """The tags that set the world."""
        return self._layout or (self._known.layout if self._known else None)

    def hear(self, stream: Stream, payload: bytes) -> bool:
        """Take in a part; return whether it says something else than before.

        Raises:
            InputError: if it cannot be used.
        """
        if stream is Stream.TAGS:
            self._layout = _usable(rig.decode_tags(payload))
        else:
            self._cameras[stream] = images.decode_calibration(payload, stream=stream)
        before = self._told.get(stream)
        self._told[stream] = _Told(payload=payload, heard_s=self._now_s())
        return before is None or before.payload != payload

    def begin_session(self) -> None:
        """Forget what was told of a session before: this one may have no tags, or other cameras."""
        for stream, told in tuple(self._told.items()):
            if self._now_s() - told.heard_s > _TOGETHER_S:
                del self._told[stream]
                self._cameras.pop(stream, None)
                if stream is Stream.TAGS:
                    self._layout = None


def _usable(layout: TagLayout) -> TagLayout:
    if layout.family not in FAMILIES or not layout.tags:
        what = f"{len(layout.tags)} tags of family '{layout.family}'"
        todo = f"send at least one tag of {', '.join(FAMILIES)}"
        raise InputError(what, where=Stream.TAGS, todo=todo)
    return layout
