"""What happens to the map, as values."""

from dataclasses import dataclass
from enum import StrEnum

from gazemap.geometry.align import Similarity
from gazemap.geometry.pose import World


class MapEventKind(StrEnum):
    """What happened."""

    NEW_MAP = "new map"
    LOOP_CLOSED = "loop closed"
    LOST = "lost"
    RELOCALISED = "relocalised"
    RE_ANCHORED = "re-anchored"
    MERGED = "merged"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MapEvent:
    """One thing that happened to the map.

    Attributes:
        kind: what happened.
        t_ns: the frame's time at which it took effect.
        map_id: the map that is tracked from then on.
        old_map_id: the map that was tracked before; the same for all but new and merged maps.
        S_new_old: maps points as they were published before into the map as it is now, or None
            where nothing moved.
    """

    kind: MapEventKind
    t_ns: int
    map_id: int
    old_map_id: int
    S_new_old: Similarity[World, World] | None = None
