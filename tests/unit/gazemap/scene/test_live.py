import numpy as np
import pytest

from gazemap.scene.config import BoxFitConfig, SceneConfig
from gazemap.scene.live import LiveObjects
from tests.drawn_tabletop import DrawnBox, Rig, Tabletop

CUBE = DrawnBox(centre=(-0.1, 0.05, 0.024), yaw_rad=0.4, size_m=(0.048,) * 3, bgr=(60, 170, 60))
CELL = DrawnBox(
    centre=(0.2, -0.08, 0.009), yaw_rad=-0.2, size_m=(0.03, 0.03, 0.018), bgr=(190, 60, 40)
)
BLOCK = DrawnBox(
    centre=(0.05, 0.15, 0.017), yaw_rad=1.0, size_m=(0.07, 0.034, 0.034), bgr=(40, 40, 200)
)
MARKS = [(0.0, -0.1), (0.3, 0.1)]
CONFIG = SceneConfig(fit=BoxFitConfig(view_period_s=0.1, max_views=4))


def moved(box: DrawnBox, x: float, y: float, z: float) -> DrawnBox:
    return DrawnBox(centre=(x, y, z), yaw_rad=box.yaw_rad + 0.5, size_m=box.size_m, bgr=box.bgr)


def watch(rig: Rig, tables: list[Tabletop]) -> LiveObjects:
    live = LiveObjects(rig.overhead_camera, rig.T_world_overhead, CONFIG)
    for k, table in enumerate(tables):
        live.add(rig.overhead(table, k))
        if k % 2:
            frame, T_world_cam = rig.head(table, k)
            live.add_view(frame, rig.head_camera, T_world_cam)
    live.finish()
    return live


@pytest.fixture(scope="module")
def still() -> list[Tabletop]:
    return [Tabletop([CUBE, CELL, BLOCK], MARKS)] * 9


def nearest(live: LiveObjects, box: DrawnBox, which: int = 0):
    return min(
        live.objects,
        key=lambda o: np.linalg.norm(o.track[which].T_world_body.t - np.array(box.centre)),
    )


def test_boxes_are_found_where_they_stand_and_marks_are_not(rig, still):
    live = watch(rig, still)
    assert len(live.objects) == 3
    for box in (CUBE, CELL, BLOCK):
        thing = nearest(live, box)
        assert np.linalg.norm(thing.track[0].T_world_body.t - box.centre) < 0.004
        assert np.sort(thing.size_m) == pytest.approx(np.sort(box.size_m), abs=0.005)
        assert thing.track[0].t_ns == 0
        assert thing.track[0].left_ns is None


def test_a_carried_box_is_the_same_thing_at_its_new_place(rig):
    there = moved(CELL, -0.25, -0.1, 0.009)
    frames = [Tabletop([CUBE, CELL], MARKS)] * 10 + [Tabletop([CUBE], MARKS)] * 10
    live = watch(rig, frames + [Tabletop([CUBE, there], MARKS)] * 9)
    assert len(live.objects) == 2
    thing = nearest(live, CELL)
    assert len(thing.track) == 2
    assert thing.track[0].left_ns == pytest.approx(0.95e9, abs=0.15e9)
    assert thing.track[1].t_ns == pytest.approx(1.95e9, abs=0.15e9)
    assert thing.at(int(1.5e9)) is None
    assert np.linalg.norm(thing.track[1].T_world_body.t - there.centre) < 0.005


def test_a_box_that_only_seemed_to_leave_stays_and_lends_its_twin_no_name(rig):
    twin = moved(CUBE, 0.2, -0.08, 0.024)
    there = moved(CUBE, -0.25, -0.12, 0.024)
    hidden = [Tabletop([CUBE, twin], MARKS)] * 20 + [Tabletop([twin], MARKS)] * 10
    frames = [*hidden, *[Tabletop([CUBE], MARKS)] * 10, *[Tabletop([CUBE, there], MARKS)] * 9]
    live = watch(rig, frames)
    assert len(live.objects) == 2
    stayed, carried = nearest(live, CUBE), nearest(live, twin)
    assert [(s.t_ns, s.left_ns) for s in stayed.track] == [(0, None)]
    assert len(carried.track) == 2
    assert np.linalg.norm(carried.track[1].T_world_body.t - there.centre) < 0.005


def test_a_box_put_on_another_stands_on_its_top(rig):
    on_top = moved(CELL, -0.1, 0.05, 0.057)
    frames = [Tabletop([CUBE, CELL], MARKS)] * 10 + [Tabletop([CUBE], MARKS)] * 8
    live = watch(rig, frames + [Tabletop([CUBE, on_top], MARKS)] * 9)
    thing = nearest(live, on_top, which=-1)
    assert thing.track[-1].T_world_body.t[2] == pytest.approx(0.057, abs=0.004)
    assert nearest(live, CUBE).track[0].left_ns is None


def test_a_box_put_on_one_that_seemed_to_leave_is_not_taken_for_that(rig):
    """An arm hid the lower box; the patch from above is as large as before."""
    on_top = moved(CELL, -0.1, 0.05, 0.057)
    frames = [Tabletop([CUBE, CELL], MARKS)] * 10 + [Tabletop([CUBE], MARKS)] * 6
    frames += [Tabletop([], MARKS)] * 8
    live = watch(rig, [*frames, *[Tabletop([CUBE, on_top], MARKS)] * 10])
    assert len(live.objects) == 2
    thing = nearest(live, on_top, which=-1)
    assert np.linalg.norm(thing.track[-1].T_world_body.t - on_top.centre) < 0.005
    assert np.sort(thing.size_m) == pytest.approx(np.sort(CELL.size_m), abs=0.005)
    assert nearest(live, CUBE).track[-1].left_ns is None


def test_a_box_put_on_another_of_its_colour_is_found_there_and_leaves_again(rig):
    """Seen from above the stack hardly differs from the lower box."""
    dice = DrawnBox(centre=(0.2, -0.1, 0.02), yaw_rad=0.1, size_m=(0.04,) * 3, bgr=BLOCK.bgr)
    x, y, z = BLOCK.centre
    on_top, away = moved(dice, x, y, 2 * z + 0.02), moved(dice, -0.3, -0.1, 0.02)
    frames = [Tabletop([BLOCK, dice], MARKS)] * 12 + [Tabletop([BLOCK], MARKS)] * 14
    frames += [Tabletop([BLOCK, on_top], MARKS)] * 14 + [Tabletop([BLOCK], MARKS)] * 10
    live = watch(rig, [*frames, *[Tabletop([BLOCK, away], MARKS)] * 10])
    assert len(live.objects) == 2
    thing = nearest(live, dice)
    assert len(thing.track) == 3
    _, stacked, last = thing.track
    assert np.linalg.norm(stacked.T_world_body.t - on_top.centre) < 0.005
    assert stacked.t_ns == pytest.approx(2.6e9, abs=0.3e9)
    assert stacked.left_ns == pytest.approx(4.0e9, abs=0.3e9)
    assert np.linalg.norm(last.T_world_body.t - away.centre) < 0.005
    assert [s.left_ns for s in nearest(live, BLOCK).track] == [None]


def test_a_thing_that_is_gone_is_not_taken_to_stand_on_one_of_its_colour(rig):
    cell = DrawnBox(centre=CELL.centre, yaw_rad=CELL.yaw_rad, size_m=CELL.size_m, bgr=CUBE.bgr)
    frames = [Tabletop([CUBE, cell], MARKS)] * 12 + [Tabletop([CUBE], MARKS)] * 26
    live = watch(rig, frames)
    assert len(nearest(live, cell).track) == 1
    assert nearest(live, cell).track[0].left_ns == pytest.approx(1.15e9, abs=0.15e9)


def test_things_of_one_colour_that_stand_in_line_are_told_apart(rig):
    behind = DrawnBox(centre=(-0.1, 0.13, 0.009), yaw_rad=0.3, size_m=CELL.size_m, bgr=CUBE.bgr)
    live = watch(rig, [Tabletop([CUBE, behind, BLOCK], MARKS)] * 16)
    assert len(live.objects) == 3
    for box in (CUBE, behind):
        thing = nearest(live, box)
        assert np.linalg.norm(thing.track[0].T_world_body.t - box.centre) < 0.004
        assert thing.size_m[2] == pytest.approx(box.size_m[2], abs=0.005)


def test_an_arm_over_a_box_is_no_thing_of_its_own(rig):
    arm = DrawnBox(centre=(-0.1, 0.03, 0.1), yaw_rad=0.4, size_m=(0.18, 0.01, 0.2), bgr=(150,) * 3)
    frames = [Tabletop([CUBE, CELL], MARKS)] * 15 + [Tabletop([CUBE, CELL, arm], MARKS)] * 12
    live = watch(rig, frames + [Tabletop([CUBE, CELL], MARKS)] * 9)
    assert len(live.objects) == 2
    for box in (CUBE, CELL):
        assert [s.left_ns for s in nearest(live, box).track] == [None]


def test_a_known_box_is_found_behind_another_that_hides_it_from_the_head(rig):
    front = DrawnBox(centre=(0.0, 0.0, 0.03), yaw_rad=0.0, size_m=(0.06,) * 3, bgr=(60, 170, 60))
    behind = moved(CELL, 0.0, 0.072, 0.009)
    frames = [Tabletop([front, CELL], MARKS)] * 10 + [Tabletop([front], MARKS)] * 8
    live = watch(rig, frames + [Tabletop([front, behind], MARKS)] * 9)
    thing = nearest(live, CELL)
    assert len(thing.track) == 2
    assert np.linalg.norm(thing.track[1].T_world_body.t - behind.centre) < 0.006


def test_nothing_is_reported_without_views_that_tell_height(rig, still):
    live = LiveObjects(rig.overhead_camera, rig.T_world_overhead, CONFIG)
    for k, table in enumerate(still):
        live.add(rig.overhead(table, k))
    assert live.finish() == []
    assert live.objects == ()
