"""Solids as triangles, millimetres, standing on z = 0 about the origin."""

import numpy as np
from numpy.typing import NDArray

Mesh = tuple[NDArray[np.float32], NDArray[np.uint32]]


def solid(name: str) -> Mesh:
    """Return vertices (N, 3) and triangles (M, 3)."""
    return _SOLIDS[name]()


def _prism(ring: list[tuple[float, float]], height: float, kernel=(0.0, 0.0)) -> Mesh:
    """Return an outline that is seen whole from its kernel, raised to a height."""
    outline = np.asarray(ring, float)
    count = len(outline)
    low = np.column_stack([outline, np.zeros(count)])
    high = np.column_stack([outline, np.full(count, height)])
    ends = np.array([[*kernel, 0.0], [*kernel, height]])
    i, j = np.arange(count), np.roll(np.arange(count), -1)
    lids = [
        (np.full(count, 2 * count), j, i),
        (np.full(count, 2 * count + 1), count + i, count + j),
    ]
    sides = [(i, j, count + i), (j, count + j, count + i)]
    faces = np.vstack([np.column_stack(each) for each in (*lids, *sides)])
    return np.vstack([low, high, ends]).astype(np.float32), faces.astype(np.uint32)


def _box(length: float, width: float, height: float) -> Mesh:
    x, y = length / 2, width / 2
    return _prism([(-x, -y), (x, -y), (x, y), (-x, y)], height)


def _round(radius: float, height: float, *, corners: int = 64, start: float = 0.0) -> Mesh:
    angles = start + np.arange(corners) * (2 * np.pi / corners)
    return _prism([(radius * np.cos(a), radius * np.sin(a)) for a in angles], height)


def _surface(points: NDArray[np.float64], *, closed: bool) -> Mesh:
    """Return the mesh of a grid of points (R, C, 3) that closes along C, and along R if asked."""
    rows, cols = points.shape[:2]
    r, c = np.meshgrid(np.arange(rows if closed else rows - 1), np.arange(cols), indexing="ij")
    nr, nc = (r + 1) % rows, (c + 1) % cols
    at = [r * cols + c, nr * cols + c, nr * cols + nc, r * cols + nc]
    a, b, d, e = (each.ravel() for each in at)
    faces = np.vstack([np.column_stack([a, b, d]), np.column_stack([a, d, e])])
    return points.reshape(-1, 3).astype(np.float32), faces.astype(np.uint32)


def _ball(radius: float) -> Mesh:
    polar = np.linspace(1e-3, np.pi - 1e-3, 40)[:, None]
    turn = np.linspace(0, 2 * np.pi, 64, endpoint=False)[None]
    x, y = np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn)
    z = 1 + np.cos(polar) * np.ones_like(turn)
    return _surface(radius * np.stack([x, y, z], axis=-1), closed=False)


def _torus(radius: float, tube: float) -> Mesh:
    around = np.linspace(0, 2 * np.pi, 72, endpoint=False)[:, None]
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)[None]
    reach = radius + tube * np.cos(turn)
    z = tube * (1 + np.sin(turn)) * np.ones_like(around)
    return _surface(
        np.stack([reach * np.cos(around), reach * np.sin(around), z], axis=-1), closed=True
    )


def _cross(reach: float, half: float, height: float) -> Mesh:
    quarter = [(half, -reach), (half, -half), (reach, -half)]
    ring, turned = [], quarter
    for _ in range(4):
        ring += turned
        turned = [(-y, x) for x, y in turned]
    return _prism(ring, height)


_LETTER_L = [(-32, -32), (32, -32), (32, -8), (-8, -8), (-8, 32), (-32, 32)]
_SPATULA = [(-46, -9), (5, -12), (22, -24), (46, 0), (22, 24), (5, 12), (-46, 9)]
_SOLIDS = {
    "cell": lambda: _box(29, 29, 18),
    "block": lambda: _box(72, 38, 24),
    "cube": lambda: _box(48, 48, 44),
    "disc": lambda: _round(27, 20),
    "coin": lambda: _round(19, 10),
    "plate": lambda: _round(46, 12),
    "ball": lambda: _ball(36),
    "ring": lambda: _torus(40, 11),
    "cross": lambda: _cross(46, 14, 20),
    "wedge": lambda: _prism(_SPATULA, 16),
    "bar": lambda: _box(106, 24, 18),
    "tile": lambda: _box(90, 90, 10),
    "triangle": lambda: _round(40, 20, corners=3),
    "hexagon": lambda: _round(40, 16, corners=6),
    "angle": lambda: _prism(_LETTER_L, 20, kernel=(-20, -20)),
    "pen": lambda: _box(112, 10, 10),
}
