"""What things may lie on: pictures of tables, linear light reflected, one pixel a millimetre."""

import cv2
import numpy as np
from numpy.typing import NDArray

SIDE_MM = 700
Picture = NDArray[np.float32]


def table(name: str, rng: np.random.Generator, *, stains: int = 0) -> Picture:
    """Return a table (SIDE_MM, SIDE_MM, 3) BGR, grey levels of a screen."""
    picture = np.clip(_TABLES[name](rng), 0, 255).astype(np.float32)
    for _ in range(stains):
        layer = picture.copy()
        centre, axes = rng.uniform(0, SIDE_MM, 2), rng.uniform(6, 24, 2)
        ellipse = (tuple(centre.tolist()), tuple(axes.tolist()), float(rng.uniform(0, 180)))
        cv2.ellipse(layer, ellipse, rng.uniform(30, 150, 3).tolist(), -1, cv2.LINE_AA)
        picture = 0.4 * picture + 0.6 * layer
    return picture


def _clouds(rng: np.random.Generator, cell_mm: float, *, along: float = 1.0) -> Picture:
    """Return smooth noise (SIDE_MM, SIDE_MM) with a standard deviation of about 0.5."""
    shape = (max(3, int(SIDE_MM / cell_mm)), max(3, int(SIDE_MM / cell_mm / along)))
    noise = rng.standard_normal(shape).astype(np.float32)
    return 0.7 * cv2.resize(noise, (SIDE_MM, SIDE_MM), interpolation=cv2.INTER_CUBIC)


def _paint(shade, bgr) -> Picture:
    return np.asarray(shade, np.float32)[..., None] * np.asarray(bgr, np.float32)


def _wood(bgr, contrast: float):
    def draw(rng: np.random.Generator) -> Picture:
        y = np.indices((SIDE_MM, SIDE_MM))[0]
        rings = np.sin(y / 5.0 + 5 * _clouds(rng, 60, along=3))
        fibre = _clouds(rng, 1.5, along=30)
        return _paint(1 + contrast * (rings + 0.8 * fibre), bgr)

    return draw


def _plain(bgr, grain: float = 0.015):
    def draw(rng: np.random.Generator) -> Picture:
        return _paint(1 + grain * 2 * _clouds(rng, 2) + 0.05 * _clouds(rng, 150), bgr)

    return draw


def _cloth(bgr, other, *, check_mm: float):
    def draw(rng: np.random.Generator) -> Picture:
        y, x = np.indices((SIDE_MM, SIDE_MM))
        weave = 1 + 0.08 * np.sin(x * 2.1) * np.sin(y * 2.1) + 0.12 * _clouds(rng, 70)
        checks = ((x // check_mm) % 2 + (y // check_mm) % 2) / 2
        mixed = checks[..., None] * (np.asarray(other, float) - bgr) + bgr
        return (weave[..., None] * mixed).astype(np.float32)

    return draw


def _speckled(bgr, flecks):
    def draw(rng: np.random.Generator) -> Picture:
        picture = _paint(1 + 0.1 * _clouds(rng, 40), bgr)
        for fleck in flecks:
            where = _clouds(rng, 4) > 0.95
            picture[where] = fleck
        return cv2.GaussianBlur(picture, (0, 0), 0.8)

    return draw


def _marble(rng: np.random.Generator) -> Picture:
    y, x = np.indices((SIDE_MM, SIDE_MM))
    veins = np.abs(np.sin((x + y) / 70 + 4 * _clouds(rng, 90) + _clouds(rng, 25)))
    return _paint(1 - 0.35 * np.exp(-6 * veins), (214, 220, 222))


def _mat(rng: np.random.Generator) -> Picture:
    """Return a cutting mat: dark green with thin light lines."""
    picture = _paint(1 + 0.05 * _clouds(rng, 60), (86, 92, 42))
    for at in range(0, SIDE_MM, 10):
        level = 150 if at % 50 == 0 else 115
        picture[at, :] = picture[:, at] = (level, level, level - 20)
    return picture


def _planks(rng: np.random.Generator) -> Picture:
    picture = _wood((96, 138, 176), 0.05)(rng)
    for start in range(0, SIDE_MM, 90):
        picture[start : start + 90] *= rng.uniform(0.75, 1.1)
        picture[start : start + 3] *= 0.45
    return picture


_TABLES = {
    "oak": _wood((88, 130, 172), 0.06),
    "walnut": _wood((42, 62, 92), 0.09),
    "birch": _wood((168, 200, 222), 0.03),
    "planks": _planks,
    "black": _plain((36, 35, 36)),
    "grey": _plain((128, 128, 126)),
    "white": _plain((226, 230, 232)),
    "steel": _plain((168, 160, 152), 0.05),
    "teal": _plain((120, 112, 52)),
    "granite": _speckled((88, 90, 94), [(40, 40, 42), (150, 152, 158)]),
    "terrazzo": _speckled((200, 206, 210), [(90, 110, 150), (120, 130, 110), (70, 70, 74)]),
    "marble": _marble,
    "linen": _cloth((178, 196, 206), (178, 196, 206), check_mm=40),
    "gingham": _cloth((222, 224, 226), (120, 150, 110), check_mm=18),
    "checks": _cloth((190, 192, 194), (92, 90, 88), check_mm=25),
    "mat": _mat,
}
