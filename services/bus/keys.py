"""The keys of the bus: `gazemap/v1/<rig>/<stream>`."""

from typing import Final

from gazemap.wire.streams import Stream

__all__ = ["LOSSY", "PREFIX", "Stream", "alive_key", "key", "stream_of"]

PREFIX: Final = "gazemap/v1"

# Images may be dropped and are never repeated; everything else is small and must arrive.
LOSSY: Final = frozenset(
    {
        Stream.HEAD_IMAGE,
        Stream.OVERHEAD_IMAGE,
        Stream.DEPTH,
        Stream.OVERHEAD_DEPTH,
        Stream.MAP_POINTS,
        Stream.MAP_MESH,
    }
)


def key(rig: str, stream: Stream) -> str:
    """Return the key of a rig's stream."""
    return f"{PREFIX}/{rig}/{stream.value}"


def alive_key(rig: str, service: str) -> str:
    """Return the key of a service's liveliness token."""
    return f"{PREFIX}/{rig}/alive/{service}"


def stream_of(rig: str, full_key: str) -> Stream | None:
    """Return the stream of a key, or None where it is none of this rig's."""
    name = full_key.removeprefix(f"{PREFIX}/{rig}/")
    return next((each for each in Stream if each.value == name), None)
