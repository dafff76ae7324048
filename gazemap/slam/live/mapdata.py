"""The map as the mapping process holds it: keyframes, features and measurements in tables."""

from dataclasses import dataclass, field

import numpy as np

from gazemap.geometry.align import Similarity
from gazemap.geometry.arrays import BoolArray, FloatArray, ImageArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Pose, World
from gazemap.slam.live.landmarks import Landmarks, host_steps
from gazemap.slam.live.messages import KeyframeNote
from gazemap.slam.live.patches import LEVELS, STORED_SIDE, Pyramid, cut_patches
from gazemap.slam.tags import TagView
from gazemap.types.tracking import Scale


@dataclass(slots=True, kw_only=True, eq=False)
class Keyframe:
    """A keyframe; its pose moves as the map is adjusted.

    Attributes:
        pyramid: its image; None in a map that was loaded.
        T_cam_world_published: the pose that users were told, which holds the gauge; None
            where it was told in the world of another map.
    """

    keyframe_id: int
    t_ns: int
    pyramid: Pyramid | None
    T_cam_world: Pose[Cam, World]
    T_cam_world_published: Pose[Cam, World] | None
    twist: FloatArray
    tags: tuple[TagView, ...] = ()


@dataclass(slots=True, kw_only=True, eq=False)
class Features:
    """Corners with their references; those with a position are points of the map.

    Attributes:
        ids: (N,) strictly increasing.
        host: (N,) the keyframe that holds the reference.
        steps: (N, 3, 3) of `host_steps`, in the host's frame.
        references: (N, 2, S, S).
        points_world: (N, 3); NaN before the triangulation.
    """

    ids: IntArray = field(default_factory=lambda: np.empty(0, np.int64))
    host: IntArray = field(default_factory=lambda: np.empty(0, np.int64))
    steps: FloatArray = field(default_factory=lambda: np.empty((0, 3, 3)))
    references: ImageArray = field(
        default_factory=lambda: np.empty((0, LEVELS, STORED_SIDE, STORED_SIDE), np.uint8)
    )
    points_world: FloatArray = field(default_factory=lambda: np.empty((0, 3)))

    @property
    def mapped(self) -> BoolArray:
        """Which features have a position (N,)."""
        return ~np.isnan(self.points_world[:, 0])

    def rows_of(self, ids: IntArray) -> IntArray:
        """Return the rows of ids that are there."""
        return np.searchsorted(self.ids, ids)

    def has(self, ids: IntArray) -> BoolArray:
        """Return which ids are there."""
        return np.isin(ids, self.ids)


@dataclass(slots=True, kw_only=True, eq=False)
class Measurements:
    """Where keyframes saw features: parallel columns (N,); xy is undistorted."""

    keyframe: IntArray = field(default_factory=lambda: np.empty(0, np.int64))
    feature: IntArray = field(default_factory=lambda: np.empty(0, np.int64))
    uv_px: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    xy: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    sigma_px: FloatArray = field(default_factory=lambda: np.empty(0))

    def __len__(self) -> int:
        return len(self.keyframe)

    def keep(self, chosen: BoolArray) -> None:
        """Drop all rows but the chosen."""
        self.keyframe, self.feature = self.keyframe[chosen], self.feature[chosen]
        self.uv_px, self.xy = self.uv_px[chosen], self.xy[chosen]
        self.sigma_px = self.sigma_px[chosen]


class SparseMap:
    """Keyframes, features and measurements of one map."""

    def __init__(self, camera: Camera, *, map_id: int = 0) -> None:
        """Start empty."""
        self.camera = camera
        self.map_id = map_id
        self.scale = Scale.ARBITRARY
        self.keyframes: dict[int, Keyframe] = {}
        self.features = Features()
        self.measurements = Measurements()

    def add_keyframe(self, note: KeyframeNote, *, tags: tuple[TagView, ...]) -> Keyframe:
        """Add a keyframe with its measurements and new features."""
        keyframe = Keyframe(
            keyframe_id=note.keyframe_id,
            t_ns=note.t_ns,
            pyramid=Pyramid.of(note.grey),
            T_cam_world=note.T_cam_world,
            T_cam_world_published=note.T_cam_world,
            twist=note.twist,
            tags=tags,
        )
        self.keyframes[note.keyframe_id] = keyframe
        known = self.features.has(note.ids)
        self.measure(
            note.keyframe_id, note.ids[known], note.uv_px[known], sigma_px=note.sigma_px[known]
        )
        self._add_features(note)
        return keyframe

    def _add_features(self, note: KeyframeNote) -> None:
        ids, uv_px, f = note.born_ids, note.born_uv_px, self.features
        if len(ids) == 0:
            return
        f.ids = np.concatenate([f.ids, ids])
        f.host = np.concatenate([f.host, np.full(len(ids), note.keyframe_id)])
        f.steps = np.concatenate([f.steps, host_steps(self.camera, uv_px)])
        f.references = np.concatenate([f.references, cut_patches(Pyramid.of(note.grey), uv_px)])
        f.points_world = np.concatenate([f.points_world, np.full((len(ids), 3), np.nan)])
        self.measure(note.keyframe_id, ids, uv_px, sigma_px=np.full(len(ids), 0.1))

    def measure(
        self, keyframe_id: int, ids: IntArray, uv_px: FloatArray, *, sigma_px: FloatArray
    ) -> None:
        """Add where a keyframe saw features (N,)."""
        m = self.measurements
        m.keyframe = np.concatenate([m.keyframe, np.full(len(ids), keyframe_id)])
        m.feature = np.concatenate([m.feature, ids])
        m.uv_px = np.concatenate([m.uv_px, uv_px])
        m.xy = np.concatenate([m.xy, self.camera.normalize(uv_px)])
        m.sigma_px = np.concatenate([m.sigma_px, sigma_px])

    def surface_steps(self, rows: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return how points (N,) move with their host's pixel (N, 2, 3), and where they face."""
        hosts, which = np.unique(self.features.host[rows], return_inverse=True)
        poses = [self.keyframes[int(h)].T_cam_world.inverse() for h in hosts]
        R = np.array([pose.R for pose in poses]).reshape(-1, 3, 3)[which]
        centre = np.array([pose.t for pose in poses]).reshape(-1, 3)[which]
        away = self.features.points_world[rows] - centre
        range_ = np.linalg.norm(away, axis=1)
        steps = np.einsum("nij,nkj->nki", R, self.features.steps[rows, 1:]) * range_[:, None, None]
        return steps, -away / range_[:, None]

    def move(self, S: Similarity[World, World]) -> None:
        """Move keyframes and points; what was published stays."""
        for keyframe in self.keyframes.values():
            keyframe.T_cam_world = S.transform_pose(keyframe.T_cam_world.inverse()).inverse()
            keyframe.twist = keyframe.twist * np.array([1, 1, 1, *[S.scale] * 3])
        self.features.points_world = S.transform(self.features.points_world)

    def transform(self, S: Similarity[World, World]) -> None:
        """Move the whole map into another world, published poses included."""
        self.move(S)
        for keyframe in self.keyframes.values():
            if keyframe.T_cam_world_published is not None:
                published = S.transform_pose(keyframe.T_cam_world_published.inverse())
                keyframe.T_cam_world_published = published.inverse()

    def absorb(self, other: "SparseMap") -> None:
        """Take over all of another map, which is in the same world already."""
        for keyframe in other.keyframes.values():
            keyframe.T_cam_world_published = None
        self.keyframes = dict(sorted({**self.keyframes, **other.keyframes}.items()))
        mine, theirs = self.features, other.features
        order = np.argsort(np.concatenate([mine.ids, theirs.ids]), kind="stable")
        self.features = Features(
            ids=np.concatenate([mine.ids, theirs.ids])[order],
            host=np.concatenate([mine.host, theirs.host])[order],
            steps=np.concatenate([mine.steps, theirs.steps])[order],
            references=np.concatenate([mine.references, theirs.references])[order],
            points_world=np.concatenate([mine.points_world, theirs.points_world])[order],
        )
        m, n = self.measurements, other.measurements
        self.measurements = Measurements(
            keyframe=np.concatenate([m.keyframe, n.keyframe]),
            feature=np.concatenate([m.feature, n.feature]),
            uv_px=np.concatenate([m.uv_px, n.uv_px]),
            xy=np.concatenate([m.xy, n.xy]),
            sigma_px=np.concatenate([m.sigma_px, n.sigma_px]),
        )

    def view_counts(self) -> IntArray:
        """Return by how many keyframes each feature (N,) was measured."""
        rows = self.features.rows_of(self.measurements.feature)
        return np.bincount(rows, minlength=len(self.features.ids))

    def landmarks(self, ids_with_references: IntArray | None = None) -> Landmarks:
        """Return the points as tracking wants them, with the references of some or of all."""
        f = self.features
        rows = np.flatnonzero(f.mapped)
        steps, facing = self.surface_steps(rows)
        chosen = rows if ids_with_references is None else f.rows_of(ids_with_references)
        return Landmarks(
            ids=f.ids[rows],
            points_world=f.points_world[rows],
            step_world=steps,
            facing_world=facing,
            view_count=self.view_counts()[rows],
            references=f.references[chosen],
        )

    def drop_features(self, ids: IntArray) -> None:
        """Take features out with their measurements."""
        f = self.features
        stays = ~np.isin(f.ids, ids)
        f.ids, f.host, f.steps = f.ids[stays], f.host[stays], f.steps[stays]
        f.references, f.points_world = f.references[stays], f.points_world[stays]
        self.measurements.keep(~np.isin(self.measurements.feature, ids))
