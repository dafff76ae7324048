"""The colour of a surface point: a texture lookup for each ray, compiled."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import cv2
import numba
import numpy as np
from numpy.typing import NDArray

from gazemap.geometry.arrays import FloatArray, ImageArray
from gazemap.sim.surfaces import Face
from gazemap.sim.tabletop import TABLE_SIZE_M

Float32Array = NDArray[np.float32]
Int32Array = NDArray[np.int32]
_Numbers = tuple[float, ...]
_LEVELS = 6
TABLE_FACE = 0
_compiled: Callable[..., Any] = numba.njit(
    cache=True, nogil=True, error_model="numpy", fastmath=True
)


class FaceTable(NamedTuple):
    """Faces as arrays of length F: a point p has the texel `(p - corner) @ axis - 0.5`."""

    normal: FloatArray
    corner: FloatArray
    u_axis: FloatArray
    v_axis: FloatArray
    texture: Int32Array
    tint: FloatArray
    texels_per_m: FloatArray


class PictureStore(NamedTuple):
    """All pictures and their halved copies in one array of texels (N, 3), BGR.

    The others are (pictures, copies): where a copy starts, its size, and that over the original's.
    """

    texels: NDArray[np.uint8]
    offset: NDArray[np.int64]
    width: Int32Array
    height: Int32Array
    shrink_u: FloatArray
    shrink_v: FloatArray


class Samples(NamedTuple):
    """Rays to be coloured: direction (N, 3) in the camera's frame, image row and face (N,)."""

    ray_cam: Float32Array
    row: Int32Array
    face: Int32Array


class Shutter(NamedTuple):
    """Where the camera is while each image row is exposed: (H, 3, 3), (H, 3); and its focus."""

    R_world_cam: FloatArray
    p_world_cam: FloatArray
    focal_px: float


def face_table(faces: Sequence[Face], pictures: Sequence[ImageArray]) -> FaceTable:
    """Return faces as arrays."""
    across = np.array([f.across_world for f in faces])
    up = np.array([f.up_world for f in faces])
    normal = np.cross(across, up)
    texture = np.array([f.texture for f in faces], dtype=np.int32)
    height, width = np.array([pictures[i].shape[:2] for i in texture]).T
    wide, high = (across**2).sum(axis=1), (up**2).sum(axis=1)
    density = np.sqrt(width * height / np.sqrt(wide * high))
    return FaceTable(
        normal=normal / np.linalg.norm(normal, axis=1, keepdims=True),
        corner=np.array([f.corner_world + f.up_world for f in faces]),  # row 0 is the upper edge
        u_axis=across * (width / wide)[:, None],
        v_axis=-up * (height / high)[:, None],
        texture=texture,
        tint=np.array([f.tint for f in faces]),
        texels_per_m=density,
    )


def picture_store(pictures: Sequence[ImageArray]) -> PictureStore:
    """Return the pictures, each with copies halved again and again against aliasing."""
    texels, sizes = [], []
    for picture in pictures:
        image = picture
        for level in range(_LEVELS):
            if level:
                half = (max(image.shape[1] // 2, 1), max(image.shape[0] // 2, 1))
                image = np.asarray(cv2.resize(image, half, interpolation=cv2.INTER_AREA))
            texels.append(image.reshape(-1, 3))
            sizes.append(image.shape[:2])
    counts = [len(t) for t in texels]
    height, width = np.array(sizes, dtype=np.int32).reshape(-1, _LEVELS, 2).transpose(2, 0, 1)
    return PictureStore(
        texels=np.concatenate(texels),
        offset=np.cumsum([0, *counts[:-1]]).reshape(-1, _LEVELS),
        width=np.ascontiguousarray(width),
        height=np.ascontiguousarray(height),
        shrink_u=width / width[:, :1],
        shrink_v=height / height[:, :1],
    )


@_compiled
def _turn(R: FloatArray, row: int, ray: Float32Array, i: int) -> _Numbers:
    x, y, z = ray[i, 0], ray[i, 1], ray[i, 2]
    return (
        R[row, 0, 0] * x + R[row, 0, 1] * y + R[row, 0, 2] * z,
        R[row, 1, 0] * x + R[row, 1, 1] * y + R[row, 1, 2] * z,
        R[row, 2, 0] * x + R[row, 2, 1] * y + R[row, 2, 2] * z,
    )


@_compiled
def _along(axes: FloatArray, f: int, x: float, y: float, z: float) -> float:
    return float(axes[f, 0] * x + axes[f, 1] * y + axes[f, 2] * z)


@_compiled
def _texel(store: PictureStore, texture: int, level: int, uv: _Numbers) -> _Numbers:
    """Return blue, green and red of one copy of a picture, between its four nearest texels."""
    width, height = store.width[texture, level], store.height[texture, level]
    x = (uv[0] + 0.5) * store.shrink_u[texture, level] - 0.5
    y = (uv[1] + 0.5) * store.shrink_v[texture, level] - 0.5
    x, y = min(max(x, 0.0), width - 1.0), min(max(y, 0.0), height - 1.0)
    x0, y0 = int(x), int(y)
    fx, fy = x - x0, y - y0
    a = store.offset[texture, level] + y0 * width + x0
    b = a + min(1, width - 1 - x0)
    down = min(1, height - 1 - y0) * width
    c, d = a + down, b + down
    wa, wb, wc, wd = (1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy
    t = store.texels
    return (
        wa * t[a, 0] + wb * t[b, 0] + wc * t[c, 0] + wd * t[d, 0],
        wa * t[a, 1] + wb * t[b, 1] + wc * t[c, 1] + wd * t[d, 1],
        wa * t[a, 2] + wb * t[b, 2] + wc * t[c, 2] + wd * t[d, 2],
    )


@_compiled
def _light_on_table(light: ImageArray, x: float, y: float) -> float:
    """Look up the shadow picture (rows from +y down) at a point of the table top."""
    height, width = light.shape
    u = min(max((x / TABLE_SIZE_M[0] + 0.5) * width - 0.5, 0.0), width - 1.001)
    v = min(max((0.5 - y / TABLE_SIZE_M[1]) * height - 0.5, 0.0), height - 1.001)
    x0, y0 = int(u), int(v)
    fx, fy = u - x0, v - y0
    top = light[y0, x0] * (1.0 - fx) + light[y0, x0 + 1] * fx
    low = light[y0 + 1, x0] * (1.0 - fx) + light[y0 + 1, x0 + 1] * fx
    return float(top * (1.0 - fy) + low * fy) / 255.0


@_compiled
def _meet(ray: _Numbers, shutter: Shutter, row: int, faces: FaceTable, f: int) -> _Numbers:
    """Return the texel (u, v), the point's x and y, the distance and the cosine of the slant."""
    ox = shutter.p_world_cam[row, 0] - faces.corner[f, 0]
    oy = shutter.p_world_cam[row, 1] - faces.corner[f, 1]
    oz = shutter.p_world_cam[row, 2] - faces.corner[f, 2]
    slant = _along(faces.normal, f, ray[0], ray[1], ray[2])
    far = -_along(faces.normal, f, ox, oy, oz) / slant
    x, y, z = ox + far * ray[0], oy + far * ray[1], oz + far * ray[2]
    u = _along(faces.u_axis, f, x, y, z) - 0.5
    v = _along(faces.v_axis, f, x, y, z) - 0.5
    return u, v, x + faces.corner[f, 0], y + faces.corner[f, 1], far, abs(slant)


@_compiled
def shade(
    samples: Samples, shutter: Shutter, faces: FaceTable, store: PictureStore, light: ImageArray
) -> Float32Array:
    """Return the colours (N, 3), BGR, of rays that meet known faces; black where face is none.

    Rows of arrays are never taken as views here: counting their owners costs more than the rest.

    Args:
        samples: the rays; a face below 0 or beyond the table is left black.
        shutter: the camera's pose for each row.
        faces: the faces.
        store: their pictures.
        light: shadow picture of the table top (h, w), 255 is fully lit.
    """
    colours = np.zeros((len(samples.face), 3), np.float32)
    for i in range(len(samples.face)):
        f, row = samples.face[i], samples.row[i]
        if f < 0 or f >= len(faces.texture):
            continue
        ray = _turn(shutter.R_world_cam, row, samples.ray_cam, i)
        u, v, x, y, far, slant = _meet(ray, shutter, row, faces, f)
        width = far * faces.texels_per_m[f] / (shutter.focal_px * np.sqrt(slant + 0.02))
        level = min(max(np.log2(width), 0.0), _LEVELS - 1.001)
        sharp = int(level)
        part = min(max(2.0 * (level - sharp) - 0.5, 0.0), 1.0)  # half the lookups need one copy
        near = coarse = _texel(store, faces.texture[f], sharp + int(part >= 1.0), (u, v))
        if 0.0 < part < 1.0:
            coarse = _texel(store, faces.texture[f], sharp + 1, (u, v))
        tint = faces.tint[f] * (_light_on_table(light, x, y) if f == TABLE_FACE else 1.0)
        colours[i, 0] = tint * ((1.0 - part) * near[0] + part * coarse[0])
        colours[i, 1] = tint * ((1.0 - part) * near[1] + part * coarse[1])
        colours[i, 2] = tint * ((1.0 - part) * near[2] + part * coarse[2])
    return colours


@_compiled
def turned(R_world_cam: FloatArray, ray_cam: Float32Array, row: Int32Array) -> Float32Array:
    """Return directions (N, 3) in world of rays (N, 3) that are exposed with image rows (N,)."""
    directions = np.empty_like(ray_cam)
    for i in range(len(row)):
        x, y, z = _turn(R_world_cam, row[i], ray_cam, i)
        directions[i, 0], directions[i, 1], directions[i, 2] = x, y, z
    return directions
