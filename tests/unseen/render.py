"""Cast rays at a thing on a table: shade, shadow, highlight, then what a camera makes of it.

Light is linear until the end; colours are those of a screen. The camera hangs over the table,
looking straight down or tilted, and a patch is cut out of its image where the thing is: the
farther off to the side, the more of a thing's sides is seen.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from gazemap.scene.cast import open3d
from tests.unseen.solids import solid
from tests.unseen.tables import SIDE_MM, Picture

_FINE = 2  # rays a pixel and axis
_GAMMA = 2.2
Points = NDArray[np.float32]

# hue in degrees and its spread, saturation, value
COLOURS = {
    "red": (358.0, 4.0, 0.86, 0.84),
    "blue": (221.0, 5.0, 0.84, 0.80),
    "yellow": (51.0, 3.0, 0.87, 0.94),
    "green": (137.0, 6.0, 0.76, 0.60),
    "purple": (290.0, 5.0, 0.70, 0.62),
    "cyan": (185.0, 4.0, 0.70, 0.85),
    "pink": (336.0, 4.0, 0.42, 0.97),
    "white": (60.0, 90.0, 0.04, 0.97),
    "black": (240.0, 90.0, 0.15, 0.15),
    "orange": (24.0, 2.0, 0.90, 0.94),
    "brown": (22.0, 3.0, 0.60, 0.42),
    "grey": (0.0, 90.0, 0.03, 0.55),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """Table, light, camera: what the patches of one set have in common.

    Attributes:
        table: a name of `tests.unseen.tables`.
        light: brightness, 1 as usual.
        tint_bgr: of the light.
        sun_deg: azimuth and elevation of the light.
        ambient: how much of the light comes from everywhere.
        softness: of the shadow's edge, as the light's radius over its distance.
        gloss: strength of highlights.
        flicker: spread of the logarithm of brightness from patch to patch.
        noise: of the sensor, grey levels.
        blur_px: standard deviation.
        jpeg: quality.
        mm_per_px: at the table's middle.
        side_px: of a patch.
        height_mm: of the camera.
        reach_mm: things lie up to so far from the table's middle along x and y.
        aside_mm: how far the camera is off to the side.
        tilt_deg: how far it is turned from looking straight down.
        stains: on the whole table.
    """

    table: str = "oak"
    light: float = 1.0
    tint_bgr: tuple[float, float, float] = (1.0, 1.0, 1.0)
    sun_deg: tuple[float, float] = (120.0, 60.0)
    ambient: float = 0.45
    softness: float = 0.05
    gloss: float = 0.1
    flicker: float = 0.12
    noise: float = 2.5
    blur_px: float = 0.6
    jpeg: int = 90
    mm_per_px: float = 1.0
    side_px: int = 128
    height_mm: float = 1200.0
    reach_mm: float = 150.0
    aside_mm: float = 0.0
    tilt_deg: float = 0.0
    stains: int = 60


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shot:
    """One patch: the image (H, W, 3) BGR and its scale."""

    image_bgr: NDArray[np.uint8]
    mm_per_px: float


def shoot(
    thing: tuple[str, str] | None, look: Look, picture: Picture, rng: np.random.Generator
) -> Shot:
    """Return the patch of a thing (colour, shape), or of the bare table."""
    place = np.array([*rng.uniform(-look.reach_mm, look.reach_mm, 2), 0.0])
    origin, rays, mm_per_px = _rays(place, look, rng)
    scene, albedo = _scene(thing, place, rng)
    points, normals, hit = _first_hits(scene, origin, rays)
    colour = np.where(hit[..., None], albedo, _table_at(points, picture))
    light = _towards_light(look, points.shape, rng)
    lit = _is_lit(scene, points + 0.05 * normals, light)
    shine = np.maximum((normals * light).sum(axis=-1), 0) * lit
    half = light - rays
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    glint = np.maximum((normals * half).sum(axis=-1), 0) ** 40 * lit * look.gloss
    open_sky = look.ambient * (0.6 + 0.4 * normals[..., 2])
    radiance = colour * (open_sky + (1 - look.ambient) * shine)[..., None] + glint[..., None]
    return Shot(image_bgr=_exposed(radiance, look, rng), mm_per_px=mm_per_px)


def _rays(
    place: NDArray[np.float64], look: Look, rng: np.random.Generator
) -> tuple[NDArray[np.float64], Points, float]:
    """Return the camera's place, unit rays (H, W, 3) and the scale where the thing is."""
    origin = np.array([look.aside_mm, -0.6 * look.aside_mm, look.height_mm])
    focal_px = look.height_mm / look.mm_per_px
    tilt = np.deg2rad(look.tilt_deg)
    right = np.array([1.0, 0.0, 0.0])
    forward = np.array([0.0, np.sin(tilt), -np.cos(tilt)])
    down = np.cross(forward, right)
    away = place - origin
    depth = float(away @ forward)
    middle = focal_px * np.array([away @ right, away @ down]) / depth
    middle += rng.normal(0, 0.02 * look.side_px, 2)
    steps = (np.arange(look.side_px * _FINE) + 0.5) / _FINE - look.side_px / 2
    u, v = np.meshgrid(middle[0] + steps, middle[1] + steps)
    rays = forward * focal_px + u[..., None] * right + v[..., None] * down
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    return origin, rays.astype(np.float32), depth / focal_px


def _scene(thing: tuple[str, str] | None, place: NDArray[np.float64], rng: np.random.Generator):
    """Return what rays meet, and the thing's linear colour (3,)."""
    scene = open3d().t.geometry.RaycastingScene()
    ground = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32) * 5000
    scene.add_triangles(ground, np.array([[0, 1, 2], [0, 2, 3]], np.uint32))
    if thing is None:
        return scene, np.zeros(3)
    vertices, faces = solid(thing[1])
    angle = rng.uniform(0, 2 * np.pi)
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    scene.add_triangles((vertices @ turn.T + place).astype(np.float32), faces)
    return scene, _paint(thing[0], rng)


def _paint(colour: str, rng: np.random.Generator) -> NDArray[np.float64]:
    hue, spread, saturation, value = COLOURS[colour]
    hsv = np.array(
        [
            (hue + spread * rng.standard_normal()) % 360,
            np.clip(saturation + 0.03 * rng.standard_normal(), 0, 1),
            np.clip(value + 0.04 * rng.standard_normal(), 0, 1),
        ],
        np.float32,
    )
    return cv2.cvtColor(hsv.reshape(1, 1, 3), cv2.COLOR_HSV2BGR).ravel().astype(float) ** _GAMMA


def _first_hits(scene, origin, rays: Points) -> tuple[Points, Points, NDArray[np.bool_]]:
    """Return points, normals towards the camera, and whether the thing was met."""
    tensor = open3d().core.Tensor
    whole = np.concatenate([np.broadcast_to(origin, rays.shape), rays], axis=-1)
    met = scene.cast_rays(tensor(whole.astype(np.float32)))
    points = origin + rays * met["t_hit"].numpy()[..., None]
    normals = met["primitive_normals"].numpy()
    normals *= -np.sign((normals * rays).sum(axis=-1, keepdims=True))
    return points.astype(np.float32), normals, met["geometry_ids"].numpy() == 1


def _table_at(points: Points, picture: Picture) -> NDArray[np.float64]:
    at = (points[..., :2] + SIDE_MM / 2).astype(np.float32)
    screen = cv2.remap(picture, at[..., 0], at[..., 1], cv2.INTER_LINEAR, None, cv2.BORDER_REFLECT)
    return (np.clip(screen, 0, 255) / 255.0) ** _GAMMA


def _towards_light(look: Look, shape: tuple[int, ...], rng: np.random.Generator) -> Points:
    """Return unit vectors to a point of the light, another one for each ray."""
    azimuth, elevation = np.deg2rad(look.sun_deg)
    sun = np.array(
        [
            np.cos(azimuth) * np.cos(elevation),
            np.sin(azimuth) * np.cos(elevation),
            np.sin(elevation),
        ]
    )
    light = sun + look.softness * rng.standard_normal(shape)
    return (light / np.linalg.norm(light, axis=-1, keepdims=True)).astype(np.float32)


def _is_lit(scene, points: Points, light: Points) -> NDArray[np.bool_]:
    rays = np.concatenate([points, light], axis=-1).astype(np.float32)
    return ~scene.test_occlusions(open3d().core.Tensor(rays)).numpy()


def _exposed(radiance, look: Look, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Return what the camera stores."""
    radiance = radiance * look.light * np.exp(look.flicker * rng.standard_normal())
    radiance = (radiance * np.asarray(look.tint_bgr)).astype(np.float32)
    pixels = cv2.resize(radiance, (look.side_px, look.side_px), interpolation=cv2.INTER_AREA)
    if look.blur_px > 0:
        pixels = cv2.GaussianBlur(pixels, (0, 0), look.blur_px)
    screen = 255 * np.clip(pixels, 0, 1) ** (1 / _GAMMA)
    screen += rng.normal(0, look.noise, screen.shape)
    image = np.clip(np.round(screen), 0, 255).astype(np.uint8)
    _, packed = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, look.jpeg])
    return np.asarray(cv2.imdecode(packed, cv2.IMREAD_COLOR))
