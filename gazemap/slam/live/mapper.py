"""Mapping: works keyframes into the map. It knows nothing of processes; `worker.py` does."""

import logging

import numpy as np

from gazemap.errors import SolverError
from gazemap.geometry.align import Similarity
from gazemap.geometry.arrays import IntArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.live.adjustment import adjust, covisible_window
from gazemap.slam.live.config import LiveConfig
from gazemap.slam.live.landmarks import Landmarks, see
from gazemap.slam.live.mapdata import Keyframe, SparseMap
from gazemap.slam.live.messages import (
    KeyframeNote,
    MapUpdate,
    Note,
    Reply,
    StartNote,
    StartRefused,
)
from gazemap.slam.live.patches import align_patches
from gazemap.slam.live.triangulate import triangulate_new
from gazemap.slam.tag_alignment import Map, TagSighting, align_to_tags
from gazemap.slam.tags import TagDetector
from gazemap.types.map import MapEvent, MapEventKind
from gazemap.types.session import TagLayout
from gazemap.types.tracking import Scale

_log = logging.getLogger(__name__)

_LEAST_START_POINTS = 30
_CANDIDATE_AGE_KEYFRAMES = 8


class Mapper:
    """Owns one map and improves it with every keyframe."""

    def __init__(self, camera: Camera, *, layout: TagLayout | None, config: LiveConfig) -> None:
        """Start without a map."""
        self._camera, self._layout, self._config = camera, layout, config
        self._detector = (
            TagDetector(family=layout.family, camera=camera) if layout is not None else None
        )
        self._map = SparseMap(camera)
        self._map_id = 0
        self._scale = Scale.ARBITRARY
        self._told_ids: IntArray = np.empty(0, np.int64)
        self._since_full = 0

    def handle(self, note: Note) -> Reply:
        """Work in what tracking sends and return the map after it."""
        match note:
            case StartNote():
                return self._start(note)
            case KeyframeNote():
                return self._extend(note)

    def _start(self, note: StartNote) -> Reply:
        self._map = SparseMap(self._camera)
        self._map_id, self._scale = note.map_id, Scale.ARBITRARY
        self._told_ids = np.empty(0, np.int64)
        for boot_note in note.keyframes:
            self._add(boot_note)
        new_ids = triangulate_new(self._map, self._config.mapping, least_views=2)
        everything = np.array(sorted(self._map.keyframes))
        for _ in range(2):
            self._adjust(everything, rounds=20)
            self._remeasure(new_ids)
        self._adjust(everything, rounds=20)
        if self._map.features.mapped.sum() < _LEAST_START_POINTS:
            return StartRefused(reason="few points")
        for keyframe in self._map.keyframes.values():
            keyframe.T_cam_world_published = keyframe.T_cam_world
        self._anchor()
        last = note.keyframes[-1]
        event = MapEvent(
            kind=MapEventKind.NEW_MAP, t_ns=last.t_ns, map_id=note.map_id, old_map_id=note.map_id
        )
        return self._update(last.keyframe_id, events=(event,))

    def _extend(self, note: KeyframeNote) -> Reply:
        keyframe = self._add(note)
        self._measure_map(keyframe)
        new_ids = triangulate_new(self._map, self._config.mapping, least_views=3)
        self._measure_elsewhere(new_ids, keyframe)
        self._adjust(self._window(keyframe.keyframe_id), rounds=6)
        self._cull()
        events = self._anchor(t_ns=note.t_ns)
        return self._update(note.keyframe_id, events=events)

    def _add(self, note: KeyframeNote) -> Keyframe:
        tags = self._detector.detect(note.grey) if self._detector is not None else ()
        return self._map.add_keyframe(note, tags=tags)

    def _window(self, keyframe_id: int) -> IntArray:
        config = self._config.mapping
        self._since_full += 1
        count = len(self._map.keyframes)
        if count <= config.window or (
            self._since_full >= config.full_every and count <= config.full_limit
        ):
            self._since_full = 0
            return np.array(sorted(self._map.keyframes))
        return covisible_window(self._map, keyframe_id, count=config.window)

    def _adjust(self, free_ids: IntArray, *, rounds: int) -> None:
        layout = self._layout if self._scale is Scale.METRIC else None
        try:
            adjust(self._map, free_ids, layout=layout, rounds=rounds)
        except SolverError as error:
            _log.warning("map kept as it was: %s", error)

    def _measure_map(self, keyframe: Keyframe) -> None:
        """Measure the points that tracking did not choose but the keyframe sees."""
        f, m = self._map.features, self._map.measurements
        seen = m.feature[m.keyframe == keyframe.keyframe_id]
        self._measure(keyframe, np.flatnonzero(f.mapped & ~np.isin(f.ids, seen)))

    def _measure_elsewhere(self, new_ids: IntArray, keyframe: Keyframe) -> None:
        """Measure new points in the keyframes around, which saw them before they were points."""
        m = self._map.measurements
        for other_id in covisible_window(self._map, keyframe.keyframe_id, count=8):
            seen = m.feature[m.keyframe == other_id]
            ids = new_ids[~np.isin(new_ids, seen)]
            self._measure(self._map.keyframes[int(other_id)], self._map.features.rows_of(ids))

    def _remeasure(self, ids: IntArray) -> None:
        """Measure points in all keyframes anew, now that their geometry predicts their patches."""
        f, m = self._map.features, self._map.measurements
        ids = ids[self._map.features.has(ids)]
        hosts = f.host[f.rows_of(m.feature)]
        m.keep(~np.isin(m.feature, ids) | (m.keyframe == hosts))
        for keyframe in self._map.keyframes.values():
            rows = f.rows_of(ids)
            self._measure(keyframe, rows[f.host[rows] != keyframe.keyframe_id])

    def _measure(self, keyframe: Keyframe, rows: IntArray) -> None:
        """Align the patches of features (rows of the table) in a keyframe."""
        if len(rows) == 0:
            return
        f = self._map.features
        steps, facing = self._map.surface_steps(rows)
        view = see(self._camera, keyframe.T_cam_world, f.points_world[rows], steps, facing)
        uv_px, correlation = align_patches(
            keyframe.pyramid, f.references[rows[view.rows]], view.from_image, view.uv_px,
            coarse=True,
        )  # fmt: skip
        config = self._config.front_end
        good = correlation > config.least_correlation
        sigma_px = np.full(int(good.sum()), config.patch_sigma_px)
        self._map.measure(
            keyframe.keyframe_id, f.ids[rows[view.rows[good]]], uv_px[good], sigma_px=sigma_px
        )

    def _cull(self) -> None:
        """Drop points with fewer than two views and corners that found no depth for long."""
        f, m = self._map.features, self._map.measurements
        counts = self._view_counts()
        keyframe_ids = sorted(self._map.keyframes)
        oldest = keyframe_ids[max(0, len(keyframe_ids) - _CANDIDATE_AGE_KEYFRAMES)]
        last_seen = np.full(len(f.ids), -1)
        np.maximum.at(last_seen, f.rows_of(m.feature), m.keyframe)
        gone = (f.mapped & (counts < 2)) | (~f.mapped & (last_seen < oldest))
        self._map.drop_features(f.ids[gone])

    def _view_counts(self) -> IntArray:
        f, m = self._map.features, self._map.measurements
        return np.bincount(f.rows_of(m.feature), minlength=len(f.ids))

    def _anchor(self, t_ns: int = 0) -> tuple[MapEvent, ...]:
        """Put the map into the world of the tags as soon as they fix it."""
        if self._layout is None or self._scale is Scale.METRIC:
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
        self._scale = Scale.METRIC
        self._adjust(np.array(sorted(self._map.keyframes)), rounds=10)
        return (
            MapEvent(
                kind=MapEventKind.RE_ANCHORED, t_ns=t_ns, map_id=self._map_id,
                old_map_id=self._map_id, S_new_old=S_new_old,
            ),
        )  # fmt: skip

    def _update(self, keyframe_id: int, *, events: tuple[MapEvent, ...]) -> MapUpdate:
        f = self._map.features
        rows = np.flatnonzero(f.mapped)
        new_ids = np.setdiff1d(f.ids[rows], self._told_ids)
        self._told_ids = f.ids[rows]
        steps, facing = self._map.surface_steps(rows)
        landmarks = Landmarks(
            ids=f.ids[rows],
            points_world=f.points_world[rows],
            step_world=steps,
            facing_world=facing,
            view_count=self._view_counts()[rows],
            references=f.references[f.rows_of(new_ids)],
        )
        poses = [k.T_cam_world.inverse() for k in self._map.keyframes.values()]
        return MapUpdate(
            keyframe_id=keyframe_id,
            T_cam_world=self._map.keyframes[keyframe_id].T_cam_world,
            landmarks=landmarks,
            new_ids=new_ids,
            keyframe_centres_world=np.array([T.t for T in poses]),
            keyframe_axes_world=np.array([T.R[:, 2] for T in poses]),
            map_id=self._map_id,
            scale=self._scale,
            events=events,
        )


def _in_map(keyframe: Keyframe) -> Pose[Map, Cam]:
    T = keyframe.T_cam_world.inverse()
    return Pose(R=T.R, t=T.t)
