"""What a map that was re-optimised did to the poses that were published in it.

Bundle adjustment, closed loops, merges and a world that tags fix all move keyframes, each by its
own amount. A pose that was published keeps its place beside the keyframe nearest to it in time.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.live.messages import MapUpdate
from gazemap.types.map import MapEvent, MapEventKind

# Smaller moves wait until they add up: they are below what a fixation shows.
_LEAST_MOVE_M = 0.001
_LEAST_TURN = 0.001


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class KeyframeMoves:
    """How the keyframes of a map moved.

    Attributes:
        old_map_id: whose poses move.
        map_id: the map in which they are then.
        moves: time of each keyframe (ns) -> its pose before and after; None where it stayed.
        scale: of the new map's lengths in the old one's.
    """

    old_map_id: int
    map_id: int
    moves: dict[int, tuple[Pose[World, Cam], Pose[World, Cam]] | None]
    scale: float

    def moved(self, t_ns: int, T_world_cam: Pose[World, Cam]) -> Pose[World, Cam] | None:
        """Return where a pose of `old_map_id` at that time is now; None where it stays."""
        move = self.moves[min(self.moves, key=lambda each_ns: abs(each_ns - t_ns))]
        if move is None:
            return None
        before, after = move
        beside = before.inverse() @ T_world_cam
        return after @ Pose(R=beside.R, t=self.scale * beside.t)


class KeyframeFollower:
    """Compares the keyframes of each map that mapping sends with those before."""

    def __init__(self) -> None:
        """Start without a map."""
        self._map_id = -1
        self._known: dict[int, Pose[World, Cam]] = {}
        self._latest: MapUpdate | None = None

    def take(self, update: MapUpdate | None, events: Sequence[MapEvent]) -> KeyframeMoves | None:
        """Take in the latest map and what happened to it; None where nothing moved."""
        if update is None or update is self._latest:
            return None
        self._latest = update
        now = dict(zip(update.keyframe_t_ns.tolist(), update.keyframe_poses, strict=True))
        old_map_id, self._map_id = self._map_id, update.map_id
        is_merged = any(
            e.kind is MapEventKind.MERGED and e.old_map_id == old_map_id for e in events
        )
        if old_map_id != update.map_id and not is_merged:
            self._known = now
            return None
        moves = {
            t_ns: (self._known[t_ns], T) if _differ(self._known[t_ns], T) else None
            for t_ns, T in now.items()
            if t_ns in self._known
        }
        stays = {t_ns: self._known[t_ns] for t_ns, move in moves.items() if move is None}
        self._known = {**now, **stays}
        if not moves or (not is_merged and len(stays) == len(moves)):
            return None
        scales = [e.S_new_old.scale for e in events if e.S_new_old is not None]
        return KeyframeMoves(
            old_map_id=old_map_id,
            map_id=update.map_id,
            moves=moves,
            scale=float(np.prod(scales)),
        )


def _differ(a: Pose[World, Cam], b: Pose[World, Cam]) -> bool:
    return bool(
        np.linalg.norm(a.t - b.t) > _LEAST_MOVE_M or np.linalg.norm(a.R - b.R) > _LEAST_TURN
    )
