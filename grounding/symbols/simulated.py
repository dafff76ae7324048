"""Simulated patches of blocks on a table, for the paper's experiment and for tests.

A patch is drawn the way an overhead camera sees a thing: a textured table with stains, a shadow,
the thing's side and its top, then the light's brightness and tint, blur and sensor noise.
"""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from grounding.types import FloatArray, ImageArray

PATCH_PX: Final = 128
_SUPERSAMPLING: Final = 2
_SIDE: Final = PATCH_PX * _SUPERSAMPLING

# hue in degrees and its spread, saturation, value
COLOURS: Final[dict[str, tuple[float, float, float, float]]] = {
    "red": (357.0, 4.0, 0.84, 0.80),
    "orange": (24.0, 3.0, 0.88, 0.90),
    "yellow": (50.0, 3.0, 0.85, 0.92),
    "green": (135.0, 6.0, 0.78, 0.58),
    "cyan": (184.0, 4.0, 0.75, 0.85),
    "blue": (222.0, 5.0, 0.82, 0.72),
    "purple": (291.0, 4.0, 0.75, 0.60),
    "pink": (335.0, 4.0, 0.42, 0.98),
    "white": (60.0, 90.0, 0.05, 0.96),
    "black": (250.0, 90.0, 0.15, 0.13),
}


class Shape(StrEnum):
    """Outlines that can be drawn."""

    CELL = "cell"
    BLOCK = "block"
    CUBE = "cube"
    DISC = "disc"
    COIN = "coin"
    PLATE = "plate"
    RING = "ring"
    CROSS = "cross"
    BAR = "bar"
    TILE = "tile"
    TRIANGLE = "triangle"
    WEDGE = "wedge"


class Table(StrEnum):
    """What the things lie on."""

    WOOD = "wood"
    DARK = "dark"
    LIGHT = "light"
    CLOTH = "cloth"


_TABLE_BGR: Final = {
    Table.WOOD: (80, 122, 165),
    Table.DARK: (52, 46, 44),
    Table.LIGHT: (196, 205, 208),
    Table.CLOTH: (104, 120, 96),
}
_TABLE_CONTRAST: Final = {Table.WOOD: 0.16, Table.DARK: 0.2, Table.LIGHT: 0.06, Table.CLOTH: 0.12}


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """What a set of patches has in common.

    Attributes:
        table: what the things lie on.
        brightness: of the light, 1 as usual.
        tint_bgr: of the light.
        unsteadiness: relative spread of the brightness from patch to patch.
        noise: standard deviation of the sensor's noise, grey levels.
        stains: expected number of stains on the table.
        mm_per_px: metric scale.
    """

    table: Table = Table.WOOD
    brightness: float = 1.0
    tint_bgr: tuple[float, float, float] = (1.0, 1.0, 1.0)
    unsteadiness: float = 0.08
    noise: float = 3.0
    stains: float = 1.5
    mm_per_px: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Thing:
    """A thing to draw.

    Attributes:
        colour: a key of `COLOURS`.
        shape: its outline.
        size: a factor of the usual size.
    """

    colour: str
    shape: Shape
    size: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Pose:
    """Where a thing lies and from where the light comes, pixels of the large canvas."""

    offset_px: FloatArray
    rotation_rad: float
    side_px: FloatArray = field(default_factory=lambda: np.zeros(2))
    shadow_px: FloatArray = field(default_factory=lambda: np.zeros(2))


def draw_patch(thing: Thing | None, scene: Scene, rng: np.random.Generator) -> ImageArray:
    """Return a patch (128, 128, 3) of a thing, or of the bare table.

    Args:
        thing: what lies in the middle, turned and shifted at random.
        scene: table, light and noise.
        rng: for all that varies from patch to patch.
    """
    canvas = _draw_table(scene, rng)
    if thing is not None:
        _draw_thing(canvas, thing, scene, rng)
    light = scene.brightness * (1 + scene.unsteadiness * rng.standard_normal())
    canvas *= np.float32(light) * np.asarray(scene.tint_bgr, np.float32)
    image = cv2.resize(canvas, (PATCH_PX, PATCH_PX), interpolation=cv2.INTER_AREA)
    image = cv2.GaussianBlur(image, (0, 0), rng.uniform(0.4, 0.8))
    image = image + rng.normal(0, scene.noise, image.shape)
    return np.clip(np.round(image), 0, 255).astype(np.uint8)


def _draw_table(scene: Scene, rng: np.random.Generator) -> NDArray[np.float32]:
    """Return the table's canvas with its grain and stains."""
    coarse = (6, 24) if scene.table is Table.WOOD else (40, 40)
    grain = cv2.resize(rng.standard_normal(coarse), (_SIDE, _SIDE), interpolation=cv2.INTER_CUBIC)
    shade = 1 + _TABLE_CONTRAST[scene.table] * 0.5 * np.tanh(grain)
    if scene.table is Table.CLOTH:
        checks = np.indices((_SIDE, _SIDE)).sum(axis=0) // (_SIDE // 16) % 2
        shade *= 1 + 0.1 * checks
    canvas = shade[..., None] * np.asarray(_TABLE_BGR[scene.table])
    canvas = np.ascontiguousarray(canvas, np.float32)
    for _ in range(rng.poisson(scene.stains)):
        layer = canvas.copy()
        centre = rng.uniform(0, _SIDE, 2)
        axes = rng.uniform(6, 24, 2)
        stain = rng.uniform(30, 130, 3)
        box = (tuple(centre.tolist()), tuple(axes.tolist()), float(rng.uniform(0, 180)))
        cv2.ellipse(layer, box, stain.tolist(), -1, cv2.LINE_AA)
        canvas = 0.35 * canvas + 0.65 * layer
    return np.asarray(canvas, np.float32)


def _draw_thing(
    canvas: NDArray[np.float32], thing: Thing, scene: Scene, rng: np.random.Generator
) -> None:
    """Draw shadow, side and top onto the canvas."""
    scale = _SUPERSAMPLING / scene.mm_per_px
    height_px = 0.12 * 40 * scale
    away = rng.uniform(0, 2 * np.pi, 2)
    pose = _Pose(
        offset_px=_SIDE / 2 + rng.normal(0, 0.02 * _SIDE, 2),
        rotation_rad=rng.uniform(0, 2 * np.pi),
        side_px=height_px * rng.uniform(0.2, 1.0) * np.array([np.cos(away[0]), np.sin(away[0])]),
        shadow_px=height_px * np.array([np.cos(away[1]), np.sin(away[1])]),
    )
    outlines = [ring * scale * thing.size for ring in _OUTLINES[thing.shape]]
    bgr = 255 * _paint(thing.colour, rng)
    shadow = cv2.GaussianBlur(_swept(outlines, pose, pose.shadow_px), (0, 0), 2.0)
    canvas *= (1 - 0.4 * shadow)[..., None]
    _cover(canvas, _swept(outlines, pose, pose.side_px), 0.6 * bgr)
    _cover(canvas, _swept(outlines, pose, np.zeros(2)), bgr)


def _cover(canvas: NDArray[np.float32], mask: NDArray[np.float32], bgr: FloatArray) -> None:
    canvas += mask[..., None] * (bgr.astype(np.float32) - canvas)


def _swept(outlines: list[FloatArray], pose: _Pose, along_px: FloatArray) -> NDArray[np.float32]:
    """Return the mask (side, side) of outlines swept along a way; the second one is a hole."""
    cosine, sine = np.cos(pose.rotation_rad), np.sin(pose.rotation_rad)
    turn = np.array([[cosine, -sine], [sine, cosine]])
    steps = int(np.linalg.norm(along_px))
    mask = np.zeros((_SIDE, _SIDE), np.uint8)
    for step in range(steps + 1):
        shift = pose.offset_px + along_px * (step / max(steps, 1))
        rings = [np.round((ring @ turn.T + shift) * 16).astype(np.int32) for ring in outlines]
        cv2.fillPoly(mask, rings, 255, cv2.LINE_AA, 4)
    return mask.astype(np.float32) / np.float32(255)


def _paint(colour: str, rng: np.random.Generator) -> FloatArray:
    """Return a colour (3,) BGR in [0, 1] with its natural spread."""
    hue, hue_spread, saturation, value = COLOURS[colour]
    hsv = np.array(
        [
            (hue + hue_spread * rng.standard_normal()) % 360,
            np.clip(saturation + 0.03 * rng.standard_normal(), 0, 1),
            np.clip(value + 0.03 * rng.standard_normal(), 0, 1),
        ],
        np.float32,
    )
    return np.asarray(cv2.cvtColor(hsv.reshape(1, 1, 3), cv2.COLOR_HSV2BGR), float).ravel()


def _rectangle(length: float, width: float) -> FloatArray:
    x, y = length / 2, width / 2
    return np.array([[-x, -y], [x, -y], [x, y], [-x, y]])


def _circle(radius: float, *, corners: int = 72) -> FloatArray:
    angles = np.arange(corners) * (2 * np.pi / corners)
    return radius * np.column_stack([np.cos(angles), np.sin(angles)])


def _cross(reach: float, half: float) -> FloatArray:
    quarter = np.array([[half, -reach], [half, -half], [reach, -half]])
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    rings = [quarter]
    for _ in range(3):
        rings.append(rings[-1] @ turn.T)
    return np.vstack(rings)


_WEDGE: Final = [[-46, -9], [5, -12], [22, -24], [46, 0], [22, 24], [5, 12], [-46, 9]]
# outer ring and holes, millimetres about the middle
_OUTLINES: Final[dict[Shape, list[FloatArray]]] = {
    Shape.CELL: [_rectangle(29, 29)],
    Shape.BLOCK: [_rectangle(72, 38)],
    Shape.CUBE: [_rectangle(48, 48)],
    Shape.DISC: [_circle(27)],
    Shape.COIN: [_circle(19)],
    Shape.PLATE: [_circle(44)],
    Shape.RING: [_circle(48), _circle(30)],
    Shape.CROSS: [_cross(45, 14)],
    Shape.BAR: [_rectangle(104, 24)],
    Shape.TILE: [_rectangle(88, 88)],
    Shape.TRIANGLE: [_circle(32, corners=3)],
    Shape.WEDGE: [np.array(_WEDGE, float)],
}
