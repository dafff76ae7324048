"""Gaze into the scene: rays many at once and one by one, growth with the mesh, a live fixation."""

import time
from collections.abc import Callable

import numpy as np

from gazemap.gaze.cast import FixationCaster
from gazemap.gaze.config import GazeNoise
from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Body, Cam, Pose, World
from gazemap.scene.cast import SceneCaster, open3d
from gazemap.scene.surface import table_mesh, with_boxes
from gazemap.types.fixation import GazeOffset
from gazemap.types.scene import ObjectState, SceneModel, SceneObject
from gazemap.types.session import Fixation
from services.bench.figures import Figure, median_ms

_OUTLINE = np.array([[-0.65, -0.45], [0.65, 0.45]])
_BATCH = 200_000
_SINGLE = 300
_USUAL, _SMALL, _LARGE = 150_000, 10_000, 2_000_000


def run() -> list[Figure]:
    """Return rates and costs of our caster beside Open3D's own."""
    usual = _model(_USUAL)
    caster = SceneCaster(usual)
    origins, directions = _rays(_BATCH)
    batch = _rate(lambda: _cast(caster, origins, directions), _BATCH, repeats=3)
    peer = _rate(lambda: _bare(usual)(origins, directions), _BATCH, repeats=3)
    single = _rate(lambda: _one_by_one(caster), _SINGLE, repeats=3)
    logarithms = float(np.log(_LARGE) / np.log(_SMALL))
    of_one, of_many = _growth()
    name = "Open3D on one mesh"
    return [
        Figure(name="rays, batched", value=batch, unit="1/s", peer=name, peer_value=peer),
        Figure(name="rays, one by one", value=single, unit="1/s", peer="wanted", peer_value=5000.0),
        Figure(
            name="a ray into 2 M over 10 k triangles",
            value=of_one,
            unit="times",
            peer="their logarithms",
            peer_value=logarithms,
        ),
        Figure(
            name="the same of rays in a batch",
            value=of_many,
            unit="times",
            peer="their logarithms",
            peer_value=logarithms,
        ),
        Figure(
            name="one live fixation",
            value=_live_ms(caster),
            unit="ms",
            peer="wanted",
            peer_value=2.0,
        ),
    ]


def _model(triangle_count: int) -> SceneModel:
    area = float(np.prod(_OUTLINE[1] - _OUTLINE[0]))
    background = table_mesh(_OUTLINE, step_m=float(np.sqrt(2 * area / triangle_count)))
    places = [(x, y) for x in (-0.4, -0.15, 0.15, 0.4) for y in (-0.2, 0.2)]
    objects = tuple(_thing(k, xy) for k, xy in enumerate(places))
    return SceneModel(
        mesh=with_boxes(background, objects),
        background=background,
        objects=objects,
        T_world_overhead=None,
        surface_sigma_m=0.0005,
    )


def _thing(k: int, xy: tuple[float, float]) -> SceneObject:
    pose = Pose[World, Body].from_rotvec([0.0, 0.0, 0.3 * k], [*xy, 0.02])
    state = ObjectState(t_ns=0, left_ns=None, T_world_body=pose, cov_world=1e-6 * np.eye(3))
    size_m = np.full(3, 0.04)
    return SceneObject(
        object_id=f"object-{k + 1}", size_m=size_m, track=(state,), mean_bgr=np.zeros(3)
    )


def _rays(count: int) -> tuple[FloatArray, FloatArray]:
    rng = np.random.default_rng(0)
    low, high = _OUTLINE
    targets = np.column_stack([low + (high - low) * rng.random((count, 2)), np.zeros(count)])
    origins = np.tile([0.0, -0.7, 0.55], (count, 1))
    away = targets - origins
    return origins, away / np.linalg.norm(away, axis=1, keepdims=True)


def _cast(caster: SceneCaster, origins: FloatArray, directions: FloatArray) -> None:
    caster.cast_batch(t_ns=0, origins_world=origins, directions_world=directions)


def _one_by_one(caster: SceneCaster) -> None:
    origins, directions = _rays(_SINGLE)
    for i in range(_SINGLE):
        rays = {"origins_world": origins[i, None], "directions_world": directions[i, None]}
        caster.cast(t_ns=0, **rays)


def _bare(model: SceneModel) -> Callable[[FloatArray, FloatArray], object]:
    o3d = open3d()
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        o3d.core.Tensor.from_numpy(model.mesh.vertices_world.astype(np.float32)),
        o3d.core.Tensor.from_numpy(model.mesh.triangles.astype(np.uint32)),
    )
    return lambda origins, directions: scene.cast_rays(
        o3d.core.Tensor.from_numpy(np.hstack([origins, directions]).astype(np.float32))
    )


def _rate(work: Callable[[], object], count: int, *, repeats: int) -> float:
    """Return how many a second of wall time, the best of some runs after a first one."""
    work()
    spans = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        spans.append(time.perf_counter() - start)
    return count / min(spans)


def _growth() -> tuple[float, float]:
    """Return how much dearer rays are in a large mesh than in a small one: one by one, batched."""
    small, large = SceneCaster(_model(_SMALL)), SceneCaster(_model(_LARGE))
    return _one_ms(large) / _one_ms(small), _batch_ms(large) / _batch_ms(small)


def _one_ms(caster: SceneCaster) -> float:
    _one_by_one(caster)
    return median_ms(lambda: _one_by_one(caster), repeats=7)


def _batch_ms(caster: SceneCaster) -> float:
    origins, directions = _rays(_BATCH)
    _cast(caster, origins, directions)
    return median_ms(lambda: _cast(caster, origins, directions), repeats=7)


def _live_ms(surface: SceneCaster) -> float:
    camera = Camera(
        width_px=800,
        height_px=600,
        K=np.array([[560.0, 0, 400], [0, 560, 300], [0, 0, 1]]),
        distortion=np.zeros(0),
    )
    offset = GazeOffset(
        azimuth_rad=0.0,
        elevation_rad=0.0,
        azimuth_sigma_rad=0.001,
        elevation_sigma_rad=0.001,
        is_applied=False,
    )
    caster = FixationCaster(camera=camera, surface=surface, offset=offset, noise=GazeNoise())
    fixation = Fixation(fixation_id=1, start_ns=0, end_ns=2, u_px=400.0, v_px=300.0)
    T_world_cam = Pose[World, Cam].from_rotvec([-2.2, 0.0, 0.0], [0.0, -0.7, 0.55])
    return median_ms(lambda: caster.cast(fixation, T_world_cam), repeats=100)
