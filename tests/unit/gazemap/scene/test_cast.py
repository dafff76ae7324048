import numpy as np
import pytest

from gazemap.geometry.pose import Pose
from gazemap.scene.cast import SceneCaster
from gazemap.scene.ray_order import MIN_RAYS
from gazemap.scene.surface import table_mesh, with_boxes
from gazemap.types.scene import Miss, ObjectState, SceneModel, SceneObject, SurfaceHit

DOWN = np.array([[0.0, 0.0, -1.0]])


@pytest.fixture(scope="module")
def caster() -> SceneCaster:
    def state(x: float, t_ns: int, left_ns: int | None) -> ObjectState:
        pose = Pose.from_rotvec([0, 0, 0.3], [x, 0.1, 0.02])
        return ObjectState(
            t_ns=t_ns, left_ns=left_ns, T_world_body=pose, cov_world=1e-6 * np.eye(3)
        )

    thing = SceneObject(
        object_id="object-1",
        size_m=np.array([0.04, 0.04, 0.04]),
        track=(state(-0.2, 0, 100), state(0.2, 200, None)),
        mean_bgr=np.zeros(3),
        size_sigma_m=0.003,
    )
    background = table_mesh(np.array([[-0.6, -0.4], [0.6, 0.4]]))
    model = SceneModel(
        mesh=with_boxes(background, (thing,)),
        background=background,
        objects=(thing,),
        T_world_overhead=None,
        surface_sigma_m=0.0005,
    )
    return SceneCaster(model)


def fall(caster: SceneCaster, t_ns: int, x: float, y: float = 0.1) -> SurfaceHit | Miss:
    return caster.cast(t_ns=t_ns, origins_world=np.array([[x, y, 1.0]]), directions_world=DOWN)[0]


def test_a_ray_meets_the_object_at_its_first_place(caster):
    hit = fall(caster, 50, -0.2)
    assert isinstance(hit, SurfaceHit)
    assert hit.object_id == "object-1"
    assert hit.point_world == pytest.approx([-0.2, 0.1, 0.04], abs=1e-6)
    assert hit.normal_world == pytest.approx([0, 0, 1], abs=1e-6)


@pytest.mark.parametrize("t_ns", [150, 250])
def test_a_thing_that_left_is_no_longer_met_there(caster, t_ns):
    hit = fall(caster, t_ns, -0.2)
    assert isinstance(hit, SurfaceHit)
    assert hit.object_id is None
    assert hit.point_world[2] == pytest.approx(0.0, abs=1e-6)


def test_a_thing_is_met_at_its_new_place_once_it_is_there(caster):
    before, after = fall(caster, 150, 0.2), fall(caster, 250, 0.2)
    assert isinstance(before, SurfaceHit)
    assert isinstance(after, SurfaceHit)
    assert (before.object_id, after.object_id) == (None, "object-1")


def test_a_ray_beside_the_table_is_a_miss(caster):
    assert isinstance(fall(caster, 0, 0.9), Miss)


def test_many_rays_give_what_single_rays_give(caster):
    rng = np.random.default_rng(5)
    origins = np.column_stack([rng.uniform(-0.5, 0.5, (40, 2)), np.full(40, 0.8)])
    directions = np.column_stack([rng.normal(0, 0.2, (40, 2)), -np.ones(40)])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    batch = caster.cast_batch(t_ns=0, origins_world=origins, directions_world=directions)
    for i in range(40):
        rays = {"origins_world": origins[i, None], "directions_world": directions[i, None]}
        one = caster.cast(t_ns=0, **rays)[0]
        assert isinstance(one, SurfaceHit) == bool(batch.is_hit[i])
        if isinstance(one, SurfaceHit):
            reach = np.linalg.norm(one.point_world - origins[i])
            assert reach == pytest.approx(batch.reach_m[i], abs=1e-6)


def test_rays_of_any_order_are_answered_in_their_own(caster):
    rng = np.random.default_rng(6)
    count = 3 * MIN_RAYS
    origins = np.column_stack([rng.uniform(-0.5, 0.5, (count, 2)), rng.uniform(0.5, 0.9, count)])
    directions = np.column_stack([rng.normal(0, 0.3, (count, 2)), -np.ones(count)])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    many = caster.cast_batch(t_ns=0, origins_world=origins, directions_world=directions)
    few = [
        caster.cast_batch(t_ns=0, origins_world=o, directions_world=d)
        for o, d in zip(np.array_split(origins, 6), np.array_split(directions, 6), strict=True)
    ]
    for name in ("reach_m", "normals_world", "object_index", "is_measured"):
        assert np.array_equal(getattr(many, name), np.concatenate([getattr(f, name) for f in few]))
    assert 0 < (many.object_index == 0).mean() < 0.2


def test_a_things_side_is_as_uncertain_as_its_place_and_size(caster):
    on_top, beside = fall(caster, 50, -0.2), fall(caster, 50, 0.0)
    assert isinstance(on_top, SurfaceHit)
    assert isinstance(beside, SurfaceHit)
    # 1 mm of the centre, and half of the extent's 3 mm.
    assert on_top.sigma_m == pytest.approx(np.hypot(0.001, 0.0015), rel=1e-6)
    assert beside.sigma_m == pytest.approx(0.0005)
