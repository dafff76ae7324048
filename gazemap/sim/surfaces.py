"""Flat textured faces in the world: the room, the table and the boxes on it."""

from dataclasses import dataclass

import numpy as np

from gazemap.geometry.arrays import FloatArray, ImageArray
from gazemap.sim import textures
from gazemap.sim.config import TabletopConfig
from gazemap.sim.tabletop import TABLE_SIZE_M, TABLE_THICKNESS_M, Block
from gazemap.sim.vocabulary import COLOURS_BGR

FLOOR_Z_M, _CEILING_Z_M, _ROOM_HALF_M, _BACK_Y_M = -0.74, 2.0, 2.2, 1.25
_SHELF_TOP_M = -0.03
LIGHT_WORLD = np.array([0.30, 0.16, 0.94])
LIGHT_WORLD /= np.linalg.norm(LIGHT_WORLD)
_AMBIENT = 0.56


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Face:
    """A parallelogram with a picture on it.

    Attributes:
        corner_world: (3,) where the picture's lower left corner is.
        across_world: (3,) from there along the picture's width.
        up_world: (3,) from there along its height.
        texture: index of the picture.
        tint: what the picture is multiplied with: the light that falls on the face.
    """

    corner_world: FloatArray
    across_world: FloatArray
    up_world: FloatArray
    texture: int
    tint: float = 1.0


def facing_light(normal_world: FloatArray) -> FloatArray:
    """Return the brightness (N,) of surfaces with unit normals (N, 3)."""
    lit: FloatArray = _AMBIENT + (1.0 - _AMBIENT) * np.clip(normal_world @ LIGHT_WORLD, 0, None)
    return lit


def box_faces(matrix: FloatArray, size_m: FloatArray, sides: tuple[int, ...]) -> list[Face]:
    """Return the six faces of a box with a body matrix (4, 4); textures of sides are reused."""
    faces: list[Face] = []
    for k, axis in enumerate((0, 0, 1, 1, 2, 2)):
        sign = 1.0 if k % 2 else -1.0
        normal = np.zeros(3)
        normal[axis] = sign
        up = np.array([0.0, 0.0, 1.0]) if axis < 2 else np.array([0.0, 1.0, 0.0])
        across = np.cross(up, normal)
        up, across = up * size_m, across * size_m
        corner = normal * size_m / 2 - up / 2 - across / 2
        R, t = matrix[:3, :3], matrix[:3, 3]
        faces.append(
            Face(
                corner_world=R @ corner + t,
                across_world=R @ across,
                up_world=R @ up,
                texture=sides[k % len(sides)],
                tint=float(facing_light((R @ normal)[None])[0]),
            )
        )
    return faces


def box_corners(matrix: FloatArray, size_m: FloatArray) -> FloatArray:
    """Return the corners (8, 3) in world of a box with a body matrix (4, 4)."""
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    corners: FloatArray = signs * size_m / 2 @ matrix[:3, :3].T + matrix[:3, 3]
    return corners


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Room:
    """Everything that stands still.

    Attributes:
        pictures: all textures; those of the blocks come last, in the blocks' order.
        faces: the static faces; the table top is the first.
        casters: corners (8, 3) of the static boxes that throw shadows on the table.
    """

    pictures: tuple[ImageArray, ...]
    faces: tuple[Face, ...]
    casters: tuple[FloatArray, ...]


def build_room(blocks: tuple[Block, ...], config: TabletopConfig, rng: np.random.Generator) -> Room:
    """Draw the room: table, floor, walls, posters, and printed boxes on a shelf behind."""
    floor = textures.cloudy((900, 900), (92, 92, 94), spread=0.10, rng=rng)
    wall = textures.cloudy((500, 250), (184, 190, 192), spread=0.012, rng=rng)
    side = textures.cloudy((300, 150), (122, 112, 110), spread=0.015, rng=rng)
    edge = textures.cloudy((400, 16), (58, 84, 118), spread=0.05, rng=rng)
    shelf = textures.cloudy((300, 150), (150, 158, 164), spread=0.012, rng=rng)
    pictures = [textures.table_top(config, rng), edge, floor, wall, side, shelf]
    faces = [*_table(), *_walls()]
    shelf_size = np.array([2.6, 0.34, _SHELF_TOP_M - FLOOR_Z_M])
    shelf_at = np.array([0.0, 0.70, (_SHELF_TOP_M + FLOOR_Z_M) / 2])
    faces += box_faces(_upright(shelf_at, 0.0), shelf_size, (5,))
    for place in range(5):
        faces.append(_poster(place, len(pictures), rng))
        pictures.append(textures.print_sheet((460, 520), marks=34, rng=rng))
    casters = []
    for x in (-0.44, -0.29, 0.31, 0.46):
        size = rng.uniform([0.09, 0.09, 0.20], [0.12, 0.12, 0.29])
        at = np.array([x, 0.62 + rng.uniform(-0.03, 0.03), _SHELF_TOP_M + size[2] / 2])
        matrix = _upright(at, float(rng.uniform(-0.5, 0.5)))
        faces += box_faces(matrix, size, (len(pictures), len(pictures) + 1))
        pictures += [textures.print_sheet((200, 420), marks=26, rng=rng) for _ in range(2)]
        casters.append(box_corners(matrix, size))
    pictures += [_paint(block, rng) for block in blocks]
    return Room(pictures=tuple(pictures), faces=tuple(faces), casters=tuple(casters))


def _upright(centre: FloatArray, yaw_rad: float) -> FloatArray:
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    matrix = np.eye(4)
    matrix[:2, :2] = [[c, -s], [s, c]]
    matrix[:3, 3] = centre
    return matrix


def _table() -> list[Face]:
    """Return the table top and what is below it; a face's place in the list tells what it is."""
    size = np.array([*TABLE_SIZE_M, TABLE_THICKNESS_M])
    below = box_faces(_upright(np.array([0.0, 0.0, -TABLE_THICKNESS_M / 2]), 0.0), size, (1,))
    top = _sheet((-size[0] / 2, -size[1] / 2, 0.0), (size[0], 0, 0), (0, size[1], 0), texture=0)
    return [top, *below[:-1]]


def _walls() -> list[Face]:
    r, z, high, back = _ROOM_HALF_M, FLOOR_Z_M, _CEILING_Z_M - FLOOR_Z_M, _BACK_Y_M
    return [
        _sheet((-r, -r, z), (2 * r, 0, 0), (0, r + back, 0), texture=2),
        _sheet((-r, back, z), (2 * r, 0, 0), (0, 0, high), texture=3, tint=0.98),
        _sheet((-r, -r, z), (0, r + back, 0), (0, 0, high), texture=4, tint=0.80),
        _sheet((r, back, z), (0, -r - back, 0), (0, 0, high), texture=4, tint=0.95),
    ]


def _sheet(
    corner: tuple[float, float, float],
    across: tuple[float, float, float],
    up: tuple[float, float, float],
    *,
    texture: int,
    tint: float = 1.0,
) -> Face:
    return Face(
        corner_world=np.array(corner),
        across_world=np.array(across, dtype=np.float64),
        up_world=np.array(up, dtype=np.float64),
        texture=texture,
        tint=tint,
    )


def _poster(place: int, texture: int, rng: np.random.Generator) -> Face:
    width, height = rng.uniform(0.34, 0.42), rng.uniform(0.36, 0.50)
    left = -1.22 + 0.54 * place + rng.uniform(-0.05, 0.05)
    corner = (left, _BACK_Y_M - 0.004, rng.uniform(0.08, 0.2))
    return _sheet(corner, (width, 0, 0), (0, 0, height), texture=texture, tint=0.95)


def _paint(block: Block, rng: np.random.Generator) -> ImageArray:
    """Return painted wood: the colour, a little uneven, a little off from block to block."""
    colour = np.array(COLOURS_BGR[block.colour], dtype=np.float64) * rng.uniform(0.93, 1.07)
    return textures.cloudy((96, 96), colour, spread=0.025, rng=rng)
