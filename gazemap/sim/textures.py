"""Pictures that surfaces are covered with: wood, tags, posters, boxes, floor and wall."""

import cv2
import numpy as np
from numpy.typing import ArrayLike

from gazemap.geometry.arrays import FloatArray, ImageArray
from gazemap.sim.config import TabletopConfig
from gazemap.sim.tabletop import TABLE_SIZE_M

TAG_FAMILY = "tag36h11"
TAG_MODULES = 8  # the black square's side
TAG_SIZE_M = 0.06
TAG_PLACES_WORLD = (
    (-0.54, -0.34), (0.54, -0.34), (-0.54, 0.34), (0.54, 0.34), (0.0, 0.36), (0.0, -0.36),
)  # fmt: skip
TABLE_PX_PER_M = 2000.0
_GRAIN_PX_PER_M = 500.0
_WOOD_BGR = np.array([[52.0, 92.0, 142.0], [112.0, 158.0, 208.0]])
_SPECKS_BGR = ((150, 82, 62), (120, 150, 70), (150, 70, 118), (160, 130, 60), (110, 70, 130))


def table_top(config: TabletopConfig, rng: np.random.Generator) -> ImageArray:
    """Return the table top seen from above, +y up, `TABLE_PX_PER_M` pixels a metre, with tags."""
    width, height = (round(side * TABLE_PX_PER_M) for side in TABLE_SIZE_M)
    coarse = _GRAIN_PX_PER_M / TABLE_PX_PER_M
    wood = _wood((round(height * coarse), round(width * coarse)), config.grain_contrast, rng=rng)
    image = np.asarray(
        cv2.resize(wood, (width, height), interpolation=cv2.INTER_CUBIC), dtype=np.uint8
    )
    for _ in range(config.speck_count):
        _draw_speck(image, rng)
    for tag_id, place in enumerate(TAG_PLACES_WORLD):
        _draw_tag(image, tag_id, place)
    return image


def _wood(shape: tuple[int, int], contrast: float, *, rng: np.random.Generator) -> ImageArray:
    """Return growth rings cut lengthwise: stripes along x, bent by smooth noise."""
    height, width = shape
    rows = np.arange(height, dtype=np.float64)[:, None] / _GRAIN_PX_PER_M
    bend_m = 0.040 * smooth_noise(shape, 7, rng) + 0.014 * smooth_noise(shape, 18, rng)
    rings = np.sin(2.0 * np.pi * (rows + bend_m) / 0.034)
    fine = np.sin(2.0 * np.pi * (rows + bend_m) / 0.0085)
    tone = 0.55 + contrast * (0.22 * rings + 0.07 * fine) + 0.07 * smooth_noise(shape, 5, rng)
    pores = cv2.resize(rng.normal(0.0, 0.03, (height, width // 6)), (width, height))
    mix = np.clip(tone + (0.3 + 0.7 * contrast) * pores, 0.0, 1.0)[:, :, None]
    return np.asarray(_WOOD_BGR[0] * (1.0 - mix) + _WOOD_BGR[1] * mix, dtype=np.uint8)


def smooth_noise(shape: tuple[int, int], cells: int, rng: np.random.Generator) -> FloatArray:
    """Return noise of an image's shape with about as many waves across as there are cells."""
    height, width = shape
    grid = rng.normal(size=(max(4, round(cells * height / width)), cells))
    return np.asarray(cv2.resize(grid, (width, height), interpolation=cv2.INTER_CUBIC))


def _draw_speck(image: ImageArray, rng: np.random.Generator) -> None:
    height, width = image.shape[:2]
    centre = (int(rng.integers(0, width)), int(rng.integers(0, height)))
    axes = tuple(int(a) for a in rng.uniform(0.004, 0.013, 2) * TABLE_PX_PER_M)
    colour = _SPECKS_BGR[int(rng.integers(len(_SPECKS_BGR)))]
    x0, y0 = (max(c - max(axes) - 2, 0) for c in centre)
    patch = image[y0 : centre[1] + max(axes) + 2, x0 : centre[0] + max(axes) + 2]
    drawn = patch.copy()
    local = (centre[0] - x0, centre[1] - y0)
    cv2.ellipse(drawn, local, axes, float(rng.uniform(0, 180)), 0, 360, colour, -1, cv2.LINE_AA)
    cv2.addWeighted(drawn, 0.75, patch, 0.25, 0.0, dst=patch)


def _draw_tag(image: ImageArray, tag_id: int, place: tuple[float, float]) -> None:
    """Paste a tag on white paper; its modules fall on whole pixels of the table's texture."""
    module_px = round(TAG_SIZE_M * TABLE_PX_PER_M / TAG_MODULES)
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    modules = cv2.aruco.generateImageMarker(dictionary, tag_id, TAG_MODULES)
    paper = cv2.copyMakeBorder(modules, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=255)
    ink = np.kron(paper, np.ones((module_px, module_px), np.uint8))
    shade = 18.0 + ink / 255.0 * (238.0 - 18.0)
    left = round((place[0] + TABLE_SIZE_M[0] / 2) * TABLE_PX_PER_M) - len(ink) // 2
    top = round((TABLE_SIZE_M[1] / 2 - place[1]) * TABLE_PX_PER_M) - len(ink) // 2
    image[top : top + len(ink), left : left + len(ink)] = shade[:, :, None]


def print_sheet(size_px: tuple[int, int], *, marks: int, rng: np.random.Generator) -> ImageArray:
    """Return a poster or a box's print, (width, height): a ground with shapes and letters."""
    width, height = size_px
    image = np.full((height, width, 3), _bright(rng), np.uint8)
    for _ in range(marks):
        at = (int(rng.integers(0, width)), int(rng.integers(0, height)))
        reach = int(rng.integers(width // 16, width // 5))
        _mark(image, at, reach=reach, rng=rng)
    for _ in range(marks // 5):
        at = (int(rng.integers(0, width)), int(rng.integers(0, height)))
        letters = "".join(chr(65 + int(c)) for c in rng.integers(0, 26, int(rng.integers(3, 7))))
        ink = tuple(int(c) for c in rng.integers(0, 110, 3))
        thick = max(2, width // 90)
        scale = width / 260.0 * float(rng.uniform(0.6, 1.4))
        cv2.putText(image, letters, at, cv2.FONT_HERSHEY_SIMPLEX, scale, ink, thick, cv2.LINE_AA)
    return image


def _mark(image: ImageArray, at: tuple[int, int], *, reach: int, rng: np.random.Generator) -> None:
    colour = _bright(rng) if rng.random() < 0.7 else _bright(rng) * 0.5
    ink = tuple(int(c) for c in colour)
    if rng.random() < 0.5:
        cv2.circle(image, at, reach // 2, ink, -1, cv2.LINE_AA)
        return
    wide, high = (int(reach * s) for s in rng.uniform(0.4, 1.6, 2))
    cv2.rectangle(image, at, (at[0] + wide, at[1] + high), ink, -1, cv2.LINE_AA)


def _bright(rng: np.random.Generator) -> FloatArray:
    hue = np.array([[[rng.uniform(0, 180), rng.uniform(50, 220), rng.uniform(150, 245)]]])
    return np.asarray(cv2.cvtColor(hue.astype(np.uint8), cv2.COLOR_HSV2BGR)[0, 0], np.float64)


def cloudy(
    size_px: tuple[int, int],
    bgr: ArrayLike,
    *,
    spread: float,
    rng: np.random.Generator,
) -> ImageArray:
    """Return a colour with soft unevenness: floor, wall, painted wood; (width, height)."""
    shape = (size_px[1], size_px[0])
    uneven = smooth_noise(shape, 6, rng) + 0.5 * smooth_noise(shape, 24, rng)
    grain = rng.normal(0.0, 0.35, shape)
    tone = 1.0 + spread * (uneven + grain)
    return np.clip(np.array(bgr) * tone[:, :, None], 0, 255).astype(np.uint8)
