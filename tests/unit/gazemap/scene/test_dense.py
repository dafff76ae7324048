import numpy as np
import pytest

from gazemap.scene.completion import planes_between
from gazemap.scene.config import SweepConfig
from gazemap.scene.dense import dense_views
from gazemap.scene.sweep import StillView, points_of, seen_depth, sweep_depth

K = np.array([[120.0, 0.0, 79.5], [0.0, 120.0, 59.5], [0.0, 0.0, 1.0]])
SHAPE = (120, 160)
WALL_M, FLOOR_M = 2.0, 3.0
CONFIG = SweepConfig(planes=48, patch_px=7, views=4)


def _texture(points, seed):
    """Grey of places (..., 2): a grid of random dots, smooth between them."""
    rng = np.random.default_rng(seed)
    dots = rng.uniform(40, 215, (64, 64))
    at = points / 0.05 + 32
    low = np.floor(at).astype(int)
    share = at - low
    low %= 63
    u, v, a, b = low[..., 0], low[..., 1], share[..., 0], share[..., 1]
    top = dots[v, u] * (1 - a) + dots[v, u + 1] * a
    return top * (1 - b) + (dots[v + 1, u] * (1 - a) + dots[v + 1, u + 1] * a) * b


def _faint(points):
    return 120 + 5 * np.sin(points[..., 0] * 15) + 5 * np.cos(points[..., 1] * 13)


def _view(x_m, y_m, window):
    """A view along z of a textured wall with a window: None, "wall" (faint) or "floor" (behind)."""
    p = np.array([x_m, y_m, 0.0])
    v, u = np.mgrid[0 : SHAPE[0], 0 : SHAPE[1]]
    rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(K).T
    on_wall, behind = (p[:2] + rays[..., :2] * far for far in (WALL_M, FLOOR_M))
    inside = np.abs(on_wall).max(axis=-1) < 0.35
    grey = _texture(on_wall, seed=1)
    if window is not None:
        grey = np.where(inside, _faint(on_wall if window == "wall" else behind), grey)
    grey = grey + np.random.default_rng(int(1e4 * (x_m + 1))).normal(0, 0.5, SHAPE)
    bgr = np.repeat(np.clip(grey, 0, 255).astype(np.uint8)[..., None], 3, axis=-1)
    return StillView(
        grey=grey.astype(np.float32), bgr=bgr, K=K, R_world_cam=np.eye(3), p_world_cam=p
    )


def _views(window):
    places = [(0.0, 0.0), (0.25, 0.0), (-0.25, 0.05), (0.05, 0.25), (0.0, -0.3), (0.3, 0.2)]
    return tuple(_view(x, y, window) for x, y in places)


def test_a_textured_wall_is_measured():
    view, *others = _views(None)
    depth = sweep_depth(view, others[:3], near=1.0, far=5.0, config=CONFIG)
    known = np.isfinite(depth)
    assert known.mean() > 0.8
    error = np.abs(depth[known] - WALL_M)
    assert 1e-6 < np.median(error) < 0.025
    assert np.quantile(error, 0.95) < 0.05


def test_depth_is_kept_where_views_agree():
    views = _views(None)
    wall = np.column_stack(
        [np.random.default_rng(0).uniform(-0.8, 0.8, (200, 2)), np.full(200, WALL_M)]
    )
    for each in dense_views(views, wall, reach=WALL_M, config=CONFIG):
        known = np.isfinite(each.measured)
        assert known.mean() > 0.6
        assert np.quantile(np.abs(each.measured[known] - WALL_M), 0.99) < 0.06


@pytest.mark.parametrize(("window", "is_filled"), [("wall", True), ("floor", False)])
def test_a_faint_part_gets_a_plane_only_where_the_views_support_it(window, is_filled):
    view, *others = _views(window)
    v, u = np.mgrid[0 : SHAPE[0], 0 : SHAPE[1]]
    on_wall = (np.stack([u, v], axis=-1) - K[:2, 2]) / K[0, 0] * WALL_M
    hidden = np.abs(on_wall).max(axis=-1) < 0.37
    measured = np.where(hidden, np.nan, WALL_M).astype(np.float32)
    rng = np.random.default_rng(0)
    filled = planes_between(view, measured, others[:3], config=CONFIG, rng=rng)
    known = np.isfinite(filled)
    assert not known[~hidden].any()
    if is_filled:
        assert known.sum() > 0.5 * hidden.sum()
        assert np.abs(filled[known] - WALL_M).max() < 0.02
    else:
        assert not known.any()


def test_points_lie_where_their_view_has_them():
    view = _view(0.2, 0.1, None)
    depth = np.full(SHAPE, WALL_M, dtype=np.float32)
    far, there = seen_depth(view, depth, points_of(view, depth))
    assert np.allclose(far, WALL_M)
    assert np.allclose(there, WALL_M)


def test_what_lies_behind_a_view_or_beside_it_has_no_depth_there():
    view = _view(0.0, 0.0, None)
    beyond = np.array([[0.0, 0.0, -1.0], [9.0, 0.0, 1.0]])
    far, there = seen_depth(view, np.ones(SHAPE, dtype=np.float32), beyond)
    assert np.isnan(far).all()
    assert np.isnan(there).all()
