"""Cut patches of what an instruction is about, while it stands still and nothing is before it."""

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from grounding.patches.level import level_crop
from grounding.patches.patch import Patch, Rejection
from grounding.patches.quality import is_blurred, is_covered, shows_object, still_picture
from grounding.patches.view import PosedCamera, View
from grounding.types import FloatArray, ImageArray


@dataclass(frozen=True, slots=True, kw_only=True)
class PatchConfig:
    """How patches are cut.

    Attributes:
        per_showing: most patches of one showing.
        looked_at: images looked at for each patch that is kept.
        margin: the patch's half side as a multiple of the thing's half diagonal in the image.
        before_s: a patch is at least so long before the thing is taken.
        after_s: a patch is at least so long after the thing was put.
        least_px: smallest half side.
        sure: least posterior of a target of which patches are kept.
        unseen_size_m: side of a thing that vision has not seen.
    """

    per_showing: int = 6
    looked_at: int = 4
    margin: float = 1.8
    before_s: float = 0.4
    after_s: float = 0.6
    least_px: int = 12
    sure: float = 0.5
    unseen_size_m: float = 0.05


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Showing:
    """A stretch of time in which an instruction's target stands still.

    Attributes:
        instruction: index of the instruction.
        symbols: its target's words.
        weight: posterior that this is the target.
        object_id: the instance, or None.
        position_world: (3,) centre.
        quat_xyzw: (4,) orientation.
        size_m: (3,) extents.
        since_ns: from when it stands there.
        until_ns: until when.
        is_looked_at: whether a look lies within three sigma of it.
    """

    instruction: int
    symbols: tuple[str, ...]
    weight: float
    object_id: str | None
    position_world: FloatArray
    quat_xyzw: FloatArray
    size_m: FloatArray
    since_ns: int
    until_ns: int
    is_looked_at: bool


def cut_patches(
    showings: Sequence[Showing], view: View, config: PatchConfig, *, first: int = 0
) -> list[Patch]:
    """Cut patches at several times of each showing.

    Args:
        showings: what to look for.
        view: the camera's recording; each image is asked for once.
        config: how.
        first: number of the first patch's name.

    Returns:
        All patches, kept or not, ordered by showing and time.
    """
    wanted = [_times(each, view, config) for each in showings]
    crops: list[list[_Crop]] = [[] for _ in showings]
    for timed in view.images(sorted({t for times in wanted for t in times})):
        camera = view.camera_at(timed.t_ns)
        for each, times, found in zip(showings, wanted, crops, strict=True):
            if camera is not None and timed.t_ns in times:
                cut = _crop if view.is_fixed else _level_crop
                found.append(cut(each, camera, timed.image_bgr, t_ns=timed.t_ns, config=config))
    names = _names(first)
    return [
        dataclasses.replace(patch, name=next(names))
        for each, found in zip(showings, crops, strict=True)
        for patch in _choose(each, found, view, config)
    ]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Crop:
    t_ns: int
    uv_px: FloatArray
    image_bgr: ImageArray | None
    mm_per_px: float | None


def _names(first: int) -> Iterator[str]:
    number = first
    while True:
        yield f"{number:06d}.png"
        number += 1


def _times(showing: Showing, view: View, config: PatchConfig) -> frozenset[int]:
    """Return times, evenly spread over the showing, the last ones nearest to the action."""
    start = showing.since_ns
    all_ns = np.asarray(view.t_ns, dtype=np.int64)
    inside = all_ns[(all_ns >= start) & (all_ns <= showing.until_ns)]
    if not len(inside):
        return frozenset()
    count = min(len(inside), config.per_showing * config.looked_at)
    picks = np.unique(np.linspace(0, len(inside) - 1, count).round().astype(int))
    return frozenset(int(t) for t in inside[picks])


def _crop(
    showing: Showing,
    camera: PosedCamera,
    image_bgr: ImageArray,
    *,
    t_ns: int,
    config: PatchConfig,
) -> _Crop:
    corners = _box_corners(showing)
    uv = camera.project(np.concatenate([showing.position_world[None], corners]))
    if not np.isfinite(uv).all():
        return _Crop(t_ns=t_ns, uv_px=uv[0], image_bgr=None, mm_per_px=None)
    half = max(config.least_px, config.margin * float(np.ptp(uv[1:], axis=0).max()) / 2)
    left, top = (round(float(x - half)) for x in uv[0])
    side = round(2 * half)
    height, width = image_bgr.shape[:2]
    if left < 0 or top < 0 or left + side > width or top + side > height:
        return _Crop(t_ns=t_ns, uv_px=uv[0], image_bgr=None, mm_per_px=None)
    return _Crop(
        t_ns=t_ns,
        uv_px=uv[0],
        image_bgr=image_bgr[top : top + side, left : left + side].copy(),
        mm_per_px=_mm_per_px(showing, camera),
    )


def _level_crop(
    showing: Showing,
    camera: PosedCamera,
    image_bgr: ImageArray,
    *,
    t_ns: int,
    config: PatchConfig,
) -> _Crop:
    """Cut from a moving camera: as from above, so that pictures of one thing can be compared."""
    top = showing.position_world + np.array([0.0, 0.0, showing.size_m[2] / 2])
    half_m = config.margin * float(np.linalg.norm(showing.size_m[:2])) / 2
    seen = level_crop(camera, image_bgr, top_world=top, half_m=half_m)
    return _Crop(
        t_ns=t_ns,
        uv_px=camera.project(showing.position_world[None])[0],
        image_bgr=None if seen is None else seen.image_bgr,
        mm_per_px=None if seen is None else seen.mm_per_px,
    )


def _box_corners(showing: Showing) -> FloatArray:
    """Return the corners (8, 3) of the thing's box."""
    signs = np.stack(np.meshgrid(*[[-0.5, 0.5]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    x, y, z, w = showing.quat_xyzw
    axis = np.array([x, y, z])
    local = signs * showing.size_m
    turned = local + 2 * np.cross(axis, np.cross(axis, local) + w * local)
    return np.asarray(showing.position_world + turned)


def _mm_per_px(showing: Showing, camera: PosedCamera) -> float | None:
    """Return the scale where the thing's top is, averaged over two directions."""
    top = showing.position_world + np.array([0.0, 0.0, showing.size_m[2] / 2])
    step = 0.01
    around = top + step * np.array([[-1.0, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0]])
    uv = camera.project(around)
    px = 0.5 * (np.linalg.norm(uv[1] - uv[0]) + np.linalg.norm(uv[3] - uv[2]))
    return float(2 * step * 1e3 / px) if np.isfinite(px) and px > 0 else None


def _choose(
    showing: Showing, crops: Sequence[_Crop], view: View, config: PatchConfig
) -> list[Patch]:
    """Judge all crops of a showing; keep some of the good ones and all that were refused."""
    images = [c.image_bgr for c in crops if c.image_bgr is not None]
    still = still_picture(images)
    covered = [
        c.image_bgr is not None
        and still is not None
        and is_covered(c.image_bgr, still, is_fixed=view.is_fixed)
        for c in crops
    ]
    judged = [
        Rejection.COVERED if hidden and seen is None else seen
        for hidden, seen in zip(
            covered, (_judge(showing, c, images, config) for c in crops), strict=True
        )
    ]
    patches = [
        Patch(
            name="",
            camera=view.name,
            t_ns=crop.t_ns,
            uv_px=crop.uv_px,
            instruction=showing.instruction,
            symbols=showing.symbols,
            weight=showing.weight,
            image_bgr=crop.image_bgr,
            mm_per_px=crop.mm_per_px,
            height_mm=float(showing.size_m[2] * 1e3) if showing.object_id else None,
            object_id=showing.object_id,
            rejection=rejection,
        )
        for crop, rejection in zip(crops, judged, strict=True)
    ]
    good = [p for p in patches if p.kept]
    spread = np.unique(np.linspace(0, len(good) - 1, config.per_showing).round().astype(int))
    kept = {good[k].t_ns for k in spread} if good else set()
    return [p for p in patches if not p.kept or p.t_ns in kept]


def _judge(
    showing: Showing,
    crop: _Crop,
    images: Sequence[ImageArray],
    config: PatchConfig,
) -> Rejection | None:
    image = crop.image_bgr
    if image is None:
        return Rejection.CUT_OFF
    if showing.weight < config.sure:
        return Rejection.DOUBTFUL
    if not showing.is_looked_at:
        return Rejection.GATE
    if is_blurred(image, images):
        return Rejection.BLURRED
    return None if shows_object(image) else Rejection.BACKGROUND
