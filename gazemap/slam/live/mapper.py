"""Mapping: works keyframes into the map. It knows nothing of processes; `worker.py` does."""

import logging
from pathlib import Path

import numpy as np

from gazemap.errors import InputError, SolverError
from gazemap.geometry.align import Similarity
from gazemap.geometry.arrays import IntArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.live.adjustment import adjust, covisible_window
from gazemap.slam.live.config import LiveConfig
from gazemap.slam.live.culling import cull_keyframes
from gazemap.slam.live.loops import LoopFinder, close_loop
from gazemap.slam.live.mapdata import Keyframe, SparseMap
from gazemap.slam.live.measuring import measure_anew, measure_elsewhere, measure_everything
from gazemap.slam.live.meeting import SleepingMap
from gazemap.slam.live.messages import (
    KeyframeNote,
    LoadNote,
    MapUpdate,
    Note,
    Refused,
    Reply,
    Saved,
    SaveNote,
    StartNote,
    StartRefused,
)
from gazemap.slam.live.store import load_map, save_map
from gazemap.slam.live.triangulate import triangulate_new
from gazemap.slam.tag_alignment import Map, TagSighting, align_to_tags
from gazemap.slam.tags import TagDetector
from gazemap.types.map import MapEvent, MapEventKind
from gazemap.types.session import TagLayout
from gazemap.types.tracking import Scale

_log = logging.getLogger(__name__)

_LEAST_START_POINTS = 30
_CANDIDATE_AGE_KEYFRAMES = 8
_ELSEWHERE_KEYFRAMES = 8
_JOINED_KEYFRAMES = 8


class Mapper:
    """Owns the present map, improves it with every keyframe, and keeps the ones before."""

    def __init__(self, camera: Camera, *, layout: TagLayout | None, config: LiveConfig) -> None:
        """Start without a map."""
        self._camera, self._layout, self._config = camera, layout, config
        self._detector = (
            TagDetector(family=layout.family, camera=camera) if layout is not None else None
        )
        self._map = SparseMap(camera)
        self._sleeping: list[SleepingMap] = []
        self._loops = LoopFinder(camera)
        self._told_ids: IntArray = np.empty(0, np.int64)
        self._since_full = 0

    def handle(self, note: Note) -> Reply:
        """Work in what tracking sends and return the map after it."""
        match note:
            case StartNote():
                return self._start(note)
            case KeyframeNote():
                return self._extend(note)
            case SaveNote():
                save_map(self._map, note.path)
                return Saved(path=note.path)
            case LoadNote():
                return self._load(note.path)

    def _start(self, note: StartNote) -> Reply:
        before, self._map = self._map, SparseMap(self._camera, map_id=note.map_id)
        for boot_note in note.keyframes:
            self._add(boot_note)
        new_ids = triangulate_new(self._map, self._config.mapping, least_views=2)
        for _ in range(2):
            self._adjust(self._all_ids(), rounds=20)
            measure_anew(self._map, new_ids, config=self._config.front_end)
        self._adjust(self._all_ids(), rounds=20)
        if self._map.features.mapped.sum() < _LEAST_START_POINTS:
            self._map = before
            return StartRefused(reason="few points")
        if before.keyframes:
            self._sleeping.append(SleepingMap(before))
        for keyframe in self._map.keyframes.values():
            keyframe.T_cam_world_published = keyframe.T_cam_world
        last = note.keyframes[-1]
        self._anchor(last.t_ns)
        event = self._event(MapEventKind.NEW_MAP, last.t_ns, old_map_id=before.map_id)
        return self._update(last.keyframe_id, events=(event,))

    def _extend(self, note: KeyframeNote) -> Reply:
        self._map.drop_features(note.vanished_ids)
        self._use_readout(note.readout_s)
        keyframe = self._add(note)
        front_end = self._config.front_end
        measure_everything(self._map, keyframe, config=front_end)
        new_ids = triangulate_new(self._map, self._config.mapping, least_views=3)
        around = covisible_window(self._map, note.keyframe_id, count=_ELSEWHERE_KEYFRAMES)
        measure_elsewhere(self._map, new_ids, around, config=front_end)
        self._adjust(self._window(note.keyframe_id), rounds=6)
        self._cull()
        events = (
            *self._anchor(note.t_ns),
            *self._close_loop(keyframe),
            *self._merge(keyframe),
        )
        return self._update(note.keyframe_id, events=events)

    def _use_readout(self, readout_s: float | None) -> None:
        """Take over a read-out time that tracking has found."""
        if readout_s != self._camera.readout_s:
            self._camera = self._camera.with_readout(readout_s)
            self._map.camera = self._camera

    def _load(self, path: Path) -> Reply:
        try:
            self._map = load_map(path, self._camera)
        except InputError as error:
            return Refused(what=error.what, where=error.where, todo=error.todo)
        self._told_ids = np.empty(0, np.int64)
        latest = self._map.keyframes[max(self._map.keyframes)]
        event = self._event(MapEventKind.NEW_MAP, latest.t_ns)
        return self._update(latest.keyframe_id, events=(event,))

    def _add(self, note: KeyframeNote) -> Keyframe:
        tags = self._detector.detect(note.grey) if self._detector is not None else ()
        return self._map.add_keyframe(note, tags=tags)

    def _all_ids(self) -> IntArray:
        return np.array(sorted(self._map.keyframes))

    def _window(self, keyframe_id: int) -> IntArray:
        config = self._config.mapping
        self._since_full += 1
        count = len(self._map.keyframes)
        if count <= config.window or (
            self._since_full >= config.full_every and count <= config.full_limit
        ):
            self._since_full = 0
            return self._all_ids()
        return covisible_window(self._map, keyframe_id, count=config.window)

    def _adjust(self, free_ids: IntArray, *, rounds: int) -> None:
        layout = self._layout if self._map.scale is Scale.METRIC else None
        try:
            adjust(self._map, free_ids, layout=layout, rounds=rounds)
        except SolverError as error:
            _log.warning("map kept as it was: %s", error)

    def _cull(self) -> None:
        """Drop points with fewer than two views and corners that found no depth for long."""
        f, m = self._map.features, self._map.measurements
        keyframe_ids = self._all_ids()
        oldest = keyframe_ids[max(0, len(keyframe_ids) - _CANDIDATE_AGE_KEYFRAMES)]
        last_seen = np.full(len(f.ids), -1)
        np.maximum.at(last_seen, f.rows_of(m.feature), m.keyframe)
        few = self._map.view_counts() < 2
        self._map.drop_features(f.ids[(f.mapped & few) | (~f.mapped & (last_seen < oldest))])
        cull_keyframes(self._map, kept=self._config.mapping.keyframes_kept)

    def _anchor(self, t_ns: int) -> tuple[MapEvent, ...]:
        """Put the map into the world of the tags as soon as they fix it."""
        if self._layout is None or self._map.scale is Scale.METRIC:
            return ()
        sightings = [
            TagSighting(T_map_cam=_in_map(k), view=view)
            for k in self._map.keyframes.values()
            for view in k.tags
        ]
        S = align_to_tags(sightings, self._layout, focal_px=float(self._camera.K[0, 0]))
        if S is None:
            return ()
        S_new_old = Similarity[World, World](scale=S.scale, R=S.R, t=S.t)
        self._map.transform(S_new_old)
        self._map.scale = Scale.METRIC
        self._adjust(self._all_ids(), rounds=10)
        return (self._event(MapEventKind.RE_ANCHORED, t_ns, S_new_old=S_new_old),)

    def _close_loop(self, keyframe: Keyframe) -> tuple[MapEvent, ...]:
        S_old_present = self._loops.find(self._map, keyframe)
        if S_old_present is None:
            return ()
        S_new_old = close_loop(self._map, keyframe, S_old_present)
        self._join(keyframe)
        return (self._event(MapEventKind.LOOP_CLOSED, keyframe.t_ns, S_new_old=S_new_old),)

    def _join(self, keyframe: Keyframe) -> None:
        """Measure what came together around a keyframe, and adjust everything."""
        for other in covisible_window(self._map, keyframe.keyframe_id, count=_JOINED_KEYFRAMES):
            frame = self._map.keyframes[int(other)]
            measure_everything(self._map, frame, config=self._config.front_end)
        self._adjust(self._all_ids(), rounds=15)

    def _merge(self, keyframe: Keyframe) -> tuple[MapEvent, ...]:
        """Join the present map with one that it meets, in whose world it then goes on."""
        for sleeping in self._sleeping:
            S_new_old = sleeping.meet(self._map, keyframe)
            if S_new_old is None:
                continue
            present, self._map = self._map, sleeping.sparse
            self._sleeping.remove(sleeping)
            present.transform(S_new_old)
            self._map.absorb(present)
            self._join(keyframe)
            return (
                self._event(
                    MapEventKind.MERGED, keyframe.t_ns, old_map_id=present.map_id,
                    S_new_old=S_new_old,
                ),
            )  # fmt: skip
        return ()

    def _event(
        self,
        kind: MapEventKind,
        t_ns: int,
        *,
        old_map_id: int | None = None,
        S_new_old: Similarity[World, World] | None = None,
    ) -> MapEvent:
        return MapEvent(
            kind=kind,
            t_ns=t_ns,
            map_id=self._map.map_id,
            old_map_id=self._map.map_id if old_map_id is None else old_map_id,
            S_new_old=S_new_old,
        )

    def _update(self, keyframe_id: int, *, events: tuple[MapEvent, ...]) -> MapUpdate:
        ids = self._map.features.ids[self._map.features.mapped]
        new_ids = np.setdiff1d(ids, self._told_ids)
        self._told_ids = ids
        poses = [k.T_cam_world.inverse() for k in self._map.keyframes.values()]
        return MapUpdate(
            keyframe_id=keyframe_id,
            T_cam_world=self._map.keyframes[keyframe_id].T_cam_world,
            landmarks=self._map.landmarks(new_ids),
            new_ids=new_ids,
            keyframe_centres_world=np.array([T.t for T in poses]),
            keyframe_axes_world=np.array([T.R[:, 2] for T in poses]),
            keyframe_t_ns=np.array([k.t_ns for k in self._map.keyframes.values()]),
            keyframe_poses=tuple(poses),
            map_id=self._map.map_id,
            scale=self._map.scale,
            events=events,
        )


def _in_map(keyframe: Keyframe) -> Pose[Map, Cam]:
    T = keyframe.T_cam_world.inverse()
    return Pose(R=T.R, t=T.t)
